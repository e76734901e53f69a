// What every shape of charges provides; one shape = one header in this folder + one line in registry.hpp.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "charge/value.hpp"

namespace dlpoly::charge {

struct ShapeInfo {
    std::string_view name;
    std::string_view description;  // one line with u(r) of two unit charges
    bool soft;                     // u is finite at r = 0
};

// A shape is a small value type:
//   static constexpr ShapeInfo info;
//   explicit Shape(double length);                  throws std::invalid_argument for a length that is not positive
//   Value operator()(double r) const noexcept;      u of two equal shapes, 1/r where they do not overlap
// length is the shape's one number, in the unit of r.

inline double positive_length(double length, std::string_view what) {
    if (!(length > 0.0) || !std::isfinite(length)) {
        throw std::invalid_argument(std::string(what) + " must be larger than 0");
    }
    return length;
}

}  // namespace dlpoly::charge
