// Pair law mlj: Lennard-Jones tapered to zero between ri and the cutoff.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/lennard_jones.hpp"
#include "pair/parameters.hpp"
#include "pair/taper.hpp"

namespace dlpoly::pair {

class TaperedLennardJones {
    static constexpr std::array<std::string_view, 3> names{"eps", "sig", "ri"};

  public:
    static constexpr LawInfo info{
        .key = "mlj",
        .description = "Lennard-Jones with the Mei-Davenport-Fernando taper from ri to the cutoff",
        .parameter_names = names,
        .energy_mask = 0b001,
        .drag_slot = 4,
        .soft = false,
        .has_tail = false,
        .mixable = true,
        .shiftable = true};

    TaperedLennardJones(std::span<const double> parameters, double cutoff)
        : TaperedLennardJones(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return value_(distance_squared); }

  private:
    TaperedLennardJones(const Parameters& given, std::span<const double> parameters, double cutoff)
        : value_(parameters.first(2), start(given, cutoff), cutoff) {}

    static double start(const Parameters& given, double cutoff) {
        given.require(given.not_negative(2) < cutoff, 2, "less than the cutoff");
        return given.any(2);
    }

    Taper<LennardJones> value_;
};

}  // namespace dlpoly::pair
