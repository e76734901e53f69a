// What every method for the interaction of two charges provides; one method = one header in this folder + one line in
// registry.hpp. A method turns a shape's u(r) into what acts within the cutoff.
#pragma once

#include <string_view>

#include "charge/value.hpp"

namespace dlpoly::charge {

struct MethodInfo {
    std::string_view name;
    std::string_view description;  // one line with u(r) of two unit point charges
    bool reciprocal;               // a sum over reciprocal vectors belongs to it
    bool smeared;                  // it knows smeared charges
};

// What the methods are made from.
struct MethodNumbers {
    double cutoff = 0.0;
    double alpha = 0.0;         // of Ewald's sum, or of the damping; 0: none
    double permittivity = 1.0;  // relative, of the reaction field's medium
};

// A method is a class template over the shape:
//   static constexpr MethodInfo info;
//   Method(Shape shape, const MethodNumbers& numbers);
//   Value operator()(double r) const noexcept;      for 0 ≤ r < cutoff

}  // namespace dlpoly::charge
