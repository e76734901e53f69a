// Two charges of density e^(−2r/λ)/πλ³, exactly: u = [1 − e^(−2x)(1 + 11x/8 + 3x²/4 + x³/6)]/r with x = r/λ.
#pragma once

#include "charge/exponential_rest.hpp"
#include "charge/shape.hpp"

namespace dlpoly::charge {

class ExactSlaterShape {
  public:
    static constexpr ShapeInfo info{
        .name = "slater-exact",
        .description = "Slater charges, [1 - exp(-2x)(1 + 11x/8 + 3x^2/4 + x^3/6)]/r, x = r/L",
        .soft = true};

    explicit ExactSlaterShape(double length) : rate_(2.0 / positive_length(length, "the length of Slater charges")) {}

    // With y = 2x, what is left of 1 = e^(−y) eʸ after the bracket is a sum of positive terms only.
    Value operator()(double r) const noexcept {
        const double y = rate_ * r;
        const double fade = std::exp(-y);
        const double energy =
            fade * (5.0 / 16.0 + y * (5.0 / 16.0 + y * (7.0 / 48.0))) + y * y * y * exponential_rest<4>(y);
        const double force = fade * (1.0 + y) / 48.0 + y * y * exponential_rest<5>(y);
        return {rate_ * energy, rate_ * rate_ * rate_ * force};
    }

  private:
    double rate_;  // 2/λ
};

}  // namespace dlpoly::charge
