// Slater charges in the usual approximation, u = [1 − (1 + βr) e^(−2βr)]/r (Groot 2003; González-Melchor and others,
// J. Chem. Phys. 125, 224107 (2006)).
#pragma once

#include "charge/exponential_rest.hpp"
#include "charge/shape.hpp"

namespace dlpoly::charge {

class SlaterShape {
  public:
    static constexpr ShapeInfo info{
        .name = "slater", .description = "approximate Slater charges, [1 - (1 + r/L) exp(-2r/L)]/r", .soft = true};

    explicit SlaterShape(double length) : rate_(2.0 / positive_length(length, "the length of Slater charges")) {}

    Value operator()(double r) const noexcept {
        const double y = rate_ * r;
        return {rate_ * (0.5 * std::exp(-y) + y * exponential_rest<2>(y)),
                rate_ * rate_ * rate_ * exponential_rest<3>(y)};
    }

  private:
    double rate_;  // 2β
};

}  // namespace dlpoly::charge
