// f · ZBL + (1 − f) · another law: nuclear repulsion at contact, a chemical law outside; for zbls and zblb.
#pragma once

#include <cmath>
#include <span>

#include "pair/law.hpp"
#include "pair/zbl.hpp"

namespace dlpoly::pair {

// f = 1 − ½ exp[−(rm − r)/xi] inside rm and ½ exp[−(r − rm)/xi] outside: value and slope are continuous at rm.
template <class Outer>
class ZblSwitch {
  public:
    // middle and width must have been checked by the law that uses this.
    ZblSwitch(std::span<const double> charges, double middle, double width, std::span<const double> outer,
              double cutoff)
        : core_(charges, cutoff), outer_(outer, cutoff), middle_(middle), inverse_width_(1.0 / width) {}

    const Outer& outer() const noexcept { return outer_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const PairValue core = core_(distance_squared);
        const PairValue outer = outer_(distance_squared);
        const double half = 0.5 * std::exp(-std::abs(distance - middle_) * inverse_width_);
        const double f = distance < middle_ ? 1.0 - half : half;
        const double minus_slope_over_r = half * inverse_width_ / distance;
        return {f * core.energy + (1.0 - f) * outer.energy, f * core.force_over_r + (1.0 - f) * outer.force_over_r +
                                                                minus_slope_over_r * (core.energy - outer.energy)};
    }

  private:
    Zbl core_;
    Outer outer_;
    double middle_, inverse_width_;
};

}  // namespace dlpoly::pair
