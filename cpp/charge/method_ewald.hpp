// The part of Ewald's sum that acts between pairs: a shape's u(r) without erf(αr)/r, which the sum over reciprocal
// vectors holds. erfc(αr)/r for point charges.
#pragma once

#include "charge/damped.hpp"
#include "charge/method.hpp"

namespace dlpoly::charge {

template <class Shape>
class EwaldReal {
  public:
    static constexpr MethodInfo info{.name = "ewald",
                                     .description =
                                         "Ewald's sum: erfc(ar)/r up to the cutoff, and the sum over "
                                         "reciprocal vectors",
                                     .reciprocal = true,
                                     .smeared = true};

    EwaldReal(Shape shape, const MethodNumbers& numbers) : base_(shape, numbers.alpha) {}

    Value operator()(double r) const noexcept { return base_(r); }

  private:
    Damped<Shape> base_;
};

}  // namespace dlpoly::charge
