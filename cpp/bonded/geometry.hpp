// Vectors between bonded beads, and the gradients of angles with respect to them.
//
// Every gradient is built from unit vectors that are made zero where they have no direction (coincident beads, straight
// angles): a force that has no direction is 0 there and never NaN.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/box.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

// The shortest of a vector's periodic images.
class MinimumImage {
  public:
    explicit MinimumImage(const Box& box) : box_(box) {
        double width = std::numeric_limits<double>::infinity();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            width = box.periodic()[axis] ? std::min(width, box.widths()[static_cast<Eigen::Index>(axis)]) : width;
        }
        limit_ = 0.5 * width;
    }

    // A vector longer than this is not known to be the shortest image.
    [[nodiscard]] double limit() const noexcept { return limit_; }

    // False when even the shortest image found is longer than the limit.
    [[nodiscard]] bool shorten(Vector3& vector) const noexcept {
        const double limit_squared = limit_ * limit_;
        if (vector.squaredNorm() <= limit_squared) {
            return true;
        }
        const Vector3 s = box_.fractional(vector);
        for (int axis = 0; axis < 3; ++axis) {
            if (box_.periodic()[static_cast<std::size_t>(axis)]) {
                vector -= std::rint(s[axis]) * box_.cell().row(axis).transpose();
            }
        }
        return vector.squaredNorm() <= limit_squared;
    }

  private:
    const Box& box_;
    double limit_;
};

// v/|v|, and the zero vector for the zero vector.
inline Vector3 direction(const Vector3& vector) noexcept {
    const double length = vector.norm();
    return length > 0.0 ? Vector3(vector / length) : Vector3(Vector3::Zero());
}

// The angle between two vectors from the vertex, and its gradient with respect to both. It has none where the vectors
// are parallel or one of them is zero; a law whose slope is zero there loses nothing.
struct Angle {
    Angle(const Vector3& a, const Vector3& b) noexcept
        : first(a.norm()), second(b.norm()), e_first(direction(a)), e_second(direction(b)) {
        const Vector3 normal = e_first.cross(e_second);
        const double sine = normal.norm();
        value = std::atan2(sine, e_first.dot(e_second));
        if (sine > 0.0) {
            by_first = e_first.cross(normal) / (sine * first);
            by_second = normal.cross(e_second) / (sine * second);
        }
    }

    double first, second;       // lengths
    Vector3 e_first, e_second;  // directions
    double value = 0.0;         // in [0, π]
    Vector3 by_first = Vector3::Zero();
    Vector3 by_second = Vector3::Zero();
};

// Below this sine the plane through three beads is nothing but round-off: no torsion, no plane, no force.
inline constexpr double least_sine = 1e-12;

// The dihedral angle of the beads i j k l from F = r_i − r_j, G = r_j − r_k and H = r_l − r_k, in DL_POLY's sign, and
// its gradient with respect to the three vectors; Blondel and Karplus, J. Comput. Chem. 17, 1132 (1996).
struct Dihedral {
    Dihedral(const Vector3& f, const Vector3& g, const Vector3& h) noexcept {
        const Vector3 a = f.cross(g);
        const Vector3 b = h.cross(g);
        const double a_squared = a.squaredNorm();
        const double b_squared = b.squaredNorm();
        const double g_squared = g.squaredNorm();
        const double least = least_sine * least_sine * g_squared;
        if (!(a_squared > least * f.squaredNorm()) || !(b_squared > least * h.squaredNorm())) {
            return;
        }
        const double length = std::sqrt(g_squared);
        value = std::atan2(-length * f.dot(b), a.dot(b));
        by_f = -length / a_squared * a;
        by_h = length / b_squared * b;
        by_g = f.dot(g) / (a_squared * length) * a - h.dot(g) / (b_squared * length) * b;
    }

    double value = 0.0;  // in (−π, π]
    Vector3 by_f = Vector3::Zero();
    Vector3 by_g = Vector3::Zero();
    Vector3 by_h = Vector3::Zero();
};

// The signed distance or angle of a vector out of the plane of two others, and its gradient with respect to all three.
struct OutOfPlane {
    double value = 0.0;
    Vector3 by_vector = Vector3::Zero();
    Vector3 by_first = Vector3::Zero();
    Vector3 by_second = Vector3::Zero();
};

// The distance of v from the plane through the origin that c and d span.
inline OutOfPlane height_above(const Vector3& v, const Vector3& c, const Vector3& d) noexcept {
    const Vector3 m = c.cross(d);
    const double size_squared = m.squaredNorm();
    if (!(size_squared > least_sine * least_sine * c.squaredNorm() * d.squaredNorm())) {
        return {};
    }
    const double size = std::sqrt(size_squared);
    const Vector3 n = m / size;
    const double height = n.dot(v);
    const Vector3 in_plane = v - height * n;
    return {height, n, d.cross(in_plane) / size, in_plane.cross(c) / size};
}

// The angle between v and that plane, in [−π/2, π/2].
inline OutOfPlane angle_above(const Vector3& v, const Vector3& c, const Vector3& d) noexcept {
    const Vector3 e = direction(v);
    const OutOfPlane sine = height_above(e, c, d);
    const Vector3& n = sine.by_vector;
    const Vector3 in_plane = e - sine.value * n;
    const double cosine = in_plane.norm();
    if (!(cosine > 0.0) || n.isZero(0.0)) {
        return {std::atan2(sine.value, cosine), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    }
    return {std::atan2(sine.value, cosine), (n - sine.value * e) / (cosine * v.norm()), sine.by_first / cosine,
            sine.by_second / cosine};
}

}  // namespace dlpoly::bonded
