// Direct Coulomb, 1/r up to the cutoff.
#pragma once

#include "charge/method.hpp"

namespace dlpoly::charge {

template <class Shape>
class Pairwise {
  public:
    static constexpr MethodInfo info{
        .name = "pairwise", .description = "1/r, truncated at the cutoff", .reciprocal = false, .smeared = true};

    Pairwise(Shape shape, const MethodNumbers& /*numbers*/) : shape_(shape) {}

    Value operator()(double r) const noexcept { return shape_(r); }

  private:
    Shape shape_;
};

}  // namespace dlpoly::charge
