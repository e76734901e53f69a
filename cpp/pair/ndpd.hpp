// Pair law ndpd: repulsion with an attractive rim, U = A b rc/(n+1) w^(n+1) − ½ A rc w², w = 1 − r/rc.
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

class NDpd {
    static constexpr std::array<std::string_view, 4> names{"A", "b", "n", "rc"};

  public:
    static constexpr LawInfo info{
        .key = "ndpd",
        .description = "many-power DPD with attraction, A b rc/(n+1) w^(n+1) - A rc/2 w^2, w = 1 - r/rc",
        .parameter_names = names,
        .energy_mask = 0b0001,
        .drag_slot = 5,
        .soft = true,
        .has_tail = false,
        .mixable = false,
        .shiftable = false};

    NDpd(std::span<const double> parameters, double cutoff) : NDpd(Parameters(info, parameters, cutoff)) {}

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double weight = std::max(0.0, 1.0 - distance * inverse_range_);
        const double repulsion = b_ * weight * power_(weight);  // b w^n
        const double energy = range_ * strength_ * weight * (repulsion * inverse_order_ - 0.5 * weight);
        return {energy, strength_ * (repulsion - weight) * inverse_or_zero(distance)};
    }

  private:
    explicit NDpd(const Parameters& given)
        : strength_(given.any(0)), b_(given.any(1)), range_(given.positive(3)), power_(given.any(2) - 1.0) {
        given.require(given.any(2) > 1.0, 2, "greater than 1, the power of the attraction");
        inverse_range_ = 1.0 / range_;
        inverse_order_ = 1.0 / (given.any(2) + 1.0);
    }

    double strength_, b_, range_, inverse_range_, inverse_order_;
    Power power_;
};

}  // namespace dlpoly::pair
