// Gaussian charges of density (2πσ²)^(−3/2) e^(−r²/2σ²), u = erf(r/2σ)/r.
#pragma once

#include "charge/screening.hpp"
#include "charge/shape.hpp"

namespace dlpoly::charge {

class GaussianShape {
  public:
    static constexpr ShapeInfo info{.name = "gaussian", .description = "Gaussian charges, erf(r/(2L))/r", .soft = true};

    explicit GaussianShape(double length)
        : cloud_(0.5 / positive_length(length, "the standard deviation of Gaussian charges")) {}

    Value operator()(double r) const noexcept { return cloud_(r); }

  private:
    Screening cloud_;
};

}  // namespace dlpoly::charge
