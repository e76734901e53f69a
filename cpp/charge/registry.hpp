// The lists of shapes and methods; a new one is one header and one line here.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "charge/kernel.hpp"
#include "charge/method_dielectric.hpp"
#include "charge/method_ewald.hpp"
#include "charge/method_pairwise.hpp"
#include "charge/method_reaction_field.hpp"
#include "charge/method_shifted.hpp"
#include "charge/shape_gaussian.hpp"
#include "charge/shape_linear.hpp"
#include "charge/shape_point.hpp"
#include "charge/shape_slater.hpp"
#include "charge/shape_slater_exact.hpp"

namespace dlpoly::charge {

// Calls f.template operator()<Shape>() for every shape.
template <class Function>
void for_each_shape(Function&& f) {
    f.template operator()<PointShape>();
    f.template operator()<SlaterShape>();
    f.template operator()<ExactSlaterShape>();
    f.template operator()<GaussianShape>();
    f.template operator()<LinearShape>();
}

// Calls f.template operator()<Method<Shape>>() for every method.
template <class Shape, class Function>
void for_each_method(Function&& f) {
    f.template operator()<Pairwise<Shape>>();
    f.template operator()<ForceShifted<Shape>>();
    f.template operator()<ReactionField<Shape>>();
    f.template operator()<DistanceDependent<Shape>>();
    f.template operator()<EwaldReal<Shape>>();
}

// Whether the method of this name sums over reciprocal vectors.
bool is_reciprocal(std::string_view method);

// Whether charges of this shape may coincide.
bool is_soft(std::string_view shape);

// The kernel of a method for charges of this shape and length. Throws std::invalid_argument for unknown names, for
// numbers that have no meaning, and for smeared charges with a method that does not know them.
std::unique_ptr<Kernel> make_kernel(std::string_view method, std::string_view shape, double length,
                                    const MethodNumbers& numbers);

}  // namespace dlpoly::charge
