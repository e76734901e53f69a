// Pair law dpd: the soft quadratic repulsion of Groot and Warren, U = ½ A rc (1 − r/rc)².
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

class Dpd {
    static constexpr std::array<std::string_view, 2> names{"A", "rc"};

  public:
    static constexpr LawInfo info{.key = "dpd",
                                  .description = "soft repulsion of DPD, A rc/2 (1 - r/rc)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b01,
                                  .drag_slot = 3,
                                  .soft = true,
                                  .has_tail = false,
                                  .mixable = true,
                                  .shiftable = false};

    Dpd(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        strength_ = given.any(0);
        range_ = given.positive(1);
        inverse_range_ = 1.0 / range_;
        half_energy_ = 0.5 * strength_ * range_;
    }

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double weight = std::max(0.0, 1.0 - distance * inverse_range_);
        return {half_energy_ * weight * weight, strength_ * weight * inverse_or_zero(distance)};
    }

  private:
    double strength_, range_, inverse_range_, half_energy_;
};

}  // namespace dlpoly::pair
