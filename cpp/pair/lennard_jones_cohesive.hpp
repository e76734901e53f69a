// Pair law ljc: Lennard-Jones with its attraction scaled by c.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/twelve_six_terms.hpp"

namespace dlpoly::pair {

class LennardJonesCohesive {
    static constexpr std::array<std::string_view, 3> names{"eps", "sig", "c"};

  public:
    static constexpr LawInfo info{
        .key = "ljc",
        .description = "Lennard-Jones with scaled attraction, 4 eps [(sig/r)^12 - c (sig/r)^6]",
        .parameter_names = names,
        .energy_mask = 0b001,
        .drag_slot = 4,
        .soft = false,
        .has_tail = true,
        .mixable = true,
        .shiftable = true};

    LennardJonesCohesive(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        const double sixth = sixth_power(given.not_negative(1));
        terms_ = {4.0 * given.any(0) * sixth * sixth, 4.0 * given.any(0) * sixth * given.any(2)};
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return terms_(distance_squared); }

  private:
    TwelveSixTerms terms_;
};

}  // namespace dlpoly::pair
