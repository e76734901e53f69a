// Coulomb with a relative permittivity of r, 1/r².
#pragma once

#include "charge/method.hpp"

namespace dlpoly::charge {

template <class Shape>
class DistanceDependent {
  public:
    static constexpr MethodInfo info{
        .name = "dddp", .description = "1/r^2, truncated at the cutoff", .reciprocal = false, .smeared = false};

    DistanceDependent(Shape /*shape*/, const MethodNumbers& /*numbers*/) {}

    Value operator()(double r) const noexcept {
        const double inverse = 1.0 / (r * r);
        return {inverse, 2.0 * inverse * inverse};
    }
};

}  // namespace dlpoly::charge
