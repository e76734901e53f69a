// A shape's u(r), damped by Fennell's factor: erfc(αr)/r for point charges (Fennell and Gezelter, J. Chem. Phys. 124,
// 234104 (2006)). α = 0 leaves the shape as it is.
#pragma once

#include "charge/screening.hpp"

namespace dlpoly::charge {

template <class Shape>
class Damped {
  public:
    Damped(Shape shape, double alpha) : shape_(shape), cloud_(alpha) {}

    Value operator()(double r) const noexcept {
        Value value = shape_(r);
        if (cloud_.alpha() > 0.0) {
            const Value taken = cloud_(r);
            value.energy -= taken.energy;
            value.factor -= taken.factor;
        }
        return value;
    }

  private:
    Shape shape_;
    Screening cloud_;
};

}  // namespace dlpoly::charge
