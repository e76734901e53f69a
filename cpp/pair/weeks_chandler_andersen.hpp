// Pair law wca: the repulsive half of Lennard-Jones, its origin moved out by D.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class WeeksChandlerAndersen {
    static constexpr std::array<std::string_view, 3> names{"eps", "sig", "D"};

  public:
    static constexpr LawInfo info{
        .key = "wca",
        .description = "Weeks-Chandler-Andersen, 4 eps [(sig/(r-D))^12 - (sig/(r-D))^6] + eps up to D + 2^(1/6) sig",
        .parameter_names = names,
        .energy_mask = 0b001,
        .drag_slot = 4,
        .soft = false,
        .has_tail = false,
        .mixable = true,
        .shiftable = false};

    WeeksChandlerAndersen(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        // DL_POLY's readings: the sign of sig is dropped and D is at most sig/2.
        const double sigma = std::abs(given.any(1));
        given.require(sigma > 0.0, 1, "other than zero");
        offset_ = std::min(given.any(2), 0.5 * sigma);
        constexpr double minimum = 1.12246204830937298143;  // 2^(1/6)
        range_ = offset_ + minimum * sigma;
        given.require(range_ > 0.0, 2, "greater than -2^(1/6) sig");
        depth_ = given.any(0);
        sigma_ = sigma;
    }

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double gap = std::max(0.0, distance - offset_);  // a bead inside D meets an infinite wall
        const double inverse = 1.0 / gap;
        const double sixth = sixth_power(sigma_ * inverse);
        const double inside = distance < range_ ? depth_ : 0.0;
        return {inside * (4.0 * sixth * (sixth - 1.0) + 1.0),
                inside * 24.0 * sixth * (2.0 * sixth - 1.0) * inverse / distance};
    }

  private:
    double depth_, sigma_, offset_, range_;
};

}  // namespace dlpoly::pair
