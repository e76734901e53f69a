// Force-shifted Coulomb, v(r) − v(rc) + F(rc)(r − rc): energy and force vanish at the cutoff. v is 1/r or, damped,
// erfc(αr)/r.
#pragma once

#include "charge/damped.hpp"
#include "charge/method.hpp"

namespace dlpoly::charge {

template <class Shape>
class ForceShifted {
  public:
    static constexpr MethodInfo info{.name = "force_shifted",
                                     .description = "1/r + r/rc^2 - 2/rc, or the same of erfc(ar)/r when damped",
                                     .reciprocal = false,
                                     .smeared = true};

    ForceShifted(Shape shape, const MethodNumbers& numbers) : base_(shape, numbers.alpha) {
        const Value end = base_(numbers.cutoff);
        force_ = end.factor * numbers.cutoff;
        offset_ = end.energy + force_ * numbers.cutoff;
    }

    Value operator()(double r) const noexcept {
        Value value = base_(r);
        value.energy += force_ * r - offset_;
        value.factor -= r > 0.0 ? force_ / r : 0.0;  // at contact smeared charges have no direction to be pushed in
        return value;
    }

  private:
    Damped<Shape> base_;
    double force_, offset_;
};

}  // namespace dlpoly::charge
