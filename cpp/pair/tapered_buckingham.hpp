// Pair law mbuc: Buckingham tapered to zero between ri and the cutoff.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/buckingham.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/taper.hpp"

namespace dlpoly::pair {

class TaperedBuckingham {
    static constexpr std::array<std::string_view, 4> names{"A", "rho", "C", "ri"};

  public:
    static constexpr LawInfo info{
        .key = "mbuc",
        .description = "Buckingham with the Mei-Davenport-Fernando taper from ri to the cutoff",
        .parameter_names = names,
        .energy_mask = 0b0101,
        .drag_slot = 5,
        .soft = false,
        .has_tail = false,
        .mixable = false,
        .shiftable = true};

    TaperedBuckingham(std::span<const double> parameters, double cutoff)
        : TaperedBuckingham(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return value_(distance_squared); }

  private:
    TaperedBuckingham(const Parameters& given, std::span<const double> parameters, double cutoff)
        : value_(parameters.first(3), start(given, cutoff), cutoff) {}

    static double start(const Parameters& given, double cutoff) {
        given.require(given.not_negative(3) < cutoff, 3, "less than the cutoff");
        return given.any(3);
    }

    Taper<Buckingham> value_;
};

}  // namespace dlpoly::pair
