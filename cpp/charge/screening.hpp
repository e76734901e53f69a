// The potential of a Gaussian cloud, u = erf(αr)/r: what Ewald's sum adds in reciprocal space, and what damping takes
// away. Regular at r = 0, where u = 2α/√π.
#pragma once

#include <cmath>

#include "charge/value.hpp"
#include "core/types.hpp"

namespace dlpoly::charge {

class Screening {
  public:
    explicit Screening(double alpha) noexcept : alpha_(alpha) {}

    [[nodiscard]] double alpha() const noexcept { return alpha_; }

    Value operator()(double r) const noexcept {
        const double x = alpha_ * r;
        const double square = x * x;
        if (x < 0.5) {
            // erf(x)/x = (2/√π) Σ (−x²)ⁿ/(n! (2n + 1)), without the cancellation of the closed form of the slope.
            double power = 1.0;
            double energy = 1.0;
            double slope = 0.0;
            for (int n = 1; n <= terms; ++n) {
                slope += 2.0 * power / (2 * n + 1);
                power *= -square / n;
                energy += power / (2 * n + 1);
            }
            return {root * alpha_ * energy, root * alpha_ * alpha_ * alpha_ * slope};
        }
        const double inverse = 1.0 / r;
        const double energy = std::erf(x) * inverse;
        return {energy, (energy - root * alpha_ * std::exp(-square)) * inverse * inverse};
    }

  private:
    static constexpr int terms = 12;
    static constexpr double root = 1.1283791670955126;  // 2/√π

    double alpha_;
};

}  // namespace dlpoly::charge
