// Small arithmetic the pair laws share; written so that loops over a law can be vectorised.
#pragma once

#include <cmath>

namespace dlpoly::pair {

// 1/r, and 0 at r = 0, where a soft law has no direction to push in. Two selects instead of a branch, and no division
// by zero on either side of them.
inline double inverse_or_zero(double distance) noexcept {
    const double divisor = distance > 0.0 ? distance : 1.0;
    return (distance > 0.0 ? 1.0 : 0.0) / divisor;
}

inline double sixth_power(double x) noexcept {
    const double square = x * x;
    return square * square * square;
}

// x^p for x ≥ 0 with an exponent fixed in advance: multiplications when p is a whole number, else std::pow.
class Power {
  public:
    explicit Power(double exponent)
        : exponent_(exponent),
          whole_(exponent >= 0.0 && exponent <= 64.0 && exponent == std::floor(exponent)),
          count_(whole_ ? static_cast<unsigned>(exponent) : 0U) {}

    double operator()(double x) const noexcept {
        if (!whole_) return std::pow(x, exponent_);
        double result = 1.0;
        double square = x;
        for (unsigned bits = count_; bits != 0U; bits >>= 1U) {
            if ((bits & 1U) != 0U) result *= square;
            square *= square;
        }
        return result;
    }

    double exponent() const noexcept { return exponent_; }

  private:
    double exponent_;
    bool whole_;
    unsigned count_;
};

}  // namespace dlpoly::pair
