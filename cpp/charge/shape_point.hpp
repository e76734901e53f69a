// Point charges, u = 1/r.
#pragma once

#include "charge/shape.hpp"

namespace dlpoly::charge {

class PointShape {
  public:
    static constexpr ShapeInfo info{.name = "point", .description = "point charges, 1/r", .soft = false};

    explicit PointShape(double /*length*/) noexcept {}

    Value operator()(double r) const noexcept {
        const double inverse = 1.0 / r;
        return {inverse, inverse * inverse * inverse};
    }
};

}  // namespace dlpoly::charge
