// A law times the Mei–Davenport–Fernando taper, which leads U and F to zero between ri and the run's cutoff.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "pair/law.hpp"

namespace dlpoly::pair {

// With x = (r − ri)/(rc − ri) from 0 to 1 the taper is (1 − x)³ (1 + 3x + 6x²) and its slope −30 x² (1 − x)²/(rc − ri).
template <class Inner>
class Taper {
  public:
    // start must have been checked by the law that uses this.
    Taper(std::span<const double> inner, double start, double cutoff)
        : inner_(inner, cutoff), start_(start), inverse_width_(1.0 / (cutoff - start)) {}

    PairValue operator()(double distance_squared) const noexcept {
        const PairValue inner = inner_(distance_squared);
        const double distance = std::sqrt(distance_squared);
        const double x = std::clamp((distance - start_) * inverse_width_, 0.0, 1.0);
        const double y = 1.0 - x;
        const double factor = y * y * y * (1.0 + x * (3.0 + 6.0 * x));
        const double minus_slope = 30.0 * x * x * y * y * inverse_width_;
        return {factor * inner.energy, factor * inner.force_over_r + minus_slope * inner.energy / distance};
    }

  private:
    Inner inner_;
    double start_, inverse_width_;
};

}  // namespace dlpoly::pair
