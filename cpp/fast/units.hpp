// What the integers of the records stand for (see records.hpp).
#pragma once

#include <cmath>

#include "core/types.hpp"
#include "fast/records.hpp"

namespace dlpoly::fast {

// Momenta are kept along box axes in units that are proportional to the edges, so that one constant for each kind turns
// momentum into fixed-point distance.
struct Units {
    Vector3 edges;    // of the box, Å
    double longest;   // of them
    double momentum;  // unit of momenta along the longest edge

    [[nodiscard]] double momentum_along(Eigen::Index axis) const { return momentum * edges[axis] / longest; }
};

// momentum_range: the largest momentum that is in range. The numbers reach further, so that leaving it is seen.
template <class Record>
Units make_units(const Vector3& edges, double momentum_range) {
    return {edges, edges.maxCoeff(), std::ldexp(1.0, std::ilogb(momentum_range) + 1 - Record::momentum_bits)};
}

// Units of fixed-point distance in an edge, and how many of their lowest bits carry no information.
template <class Record>
double fixed_range() {
    return std::ldexp(1.0, static_cast<int>(8 * sizeof(typename Record::Fixed)));
}
template <class Record>
inline constexpr int unused_bits = static_cast<int>(8 * sizeof(typename Record::Fixed)) - Record::position_bits;

// A fixed-point position along an edge, Å.
template <class Record>
inline double coordinate(typename Record::Fixed position, double edge) {
    return static_cast<double>(position >> unused_bits<Record>) * (edge * std::ldexp(1.0, -Record::position_bits));
}

}  // namespace dlpoly::fast
