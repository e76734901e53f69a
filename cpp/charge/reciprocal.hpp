// Ewald's sum over reciprocal vectors, (2π/V) Σ_{k ≠ 0} e^(−k²/4α²)/k² |Σ q e^(ik·r)|², for periodic cells of any
// shape.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "core/box.hpp"
#include "core/types.hpp"

namespace dlpoly::charge {

// Without self terms and background. The virial is Σ F_a r_b.
struct ReciprocalTotals {
    double energy = 0.0;
    Matrix3 virial = Matrix3::Zero();
};

class Reciprocal {
  public:
    Reciprocal() = default;
    Reciprocal(const Reciprocal&) = delete;
    Reciprocal& operator=(const Reciprocal&) = delete;
    Reciprocal(Reciprocal&&) = delete;
    Reciprocal& operator=(Reciprocal&&) = delete;
    virtual ~Reciprocal() = default;

    // Writes the force on every charge where `forces` is given, and the totals where they are. All sums have a fixed
    // order, whatever the number of threads.
    virtual void compute(const Box& box, const Array3N& positions, std::span<const double> charges, Array3N* forces,
                         ReciprocalTotals* totals) = 0;

    // Σ_i ∇_i² of the energy over the charges that are not frozen.
    virtual double curvature(const Box& box, const Array3N& positions, std::span<const double> charges,
                             std::span<const std::uint8_t> frozen) = 0;
};

// 2π times the reciprocal vectors of the cell, by row.
inline Matrix3 reciprocal_vectors(const Box& box) { return 2.0 * pi * box.cell().inverse().transpose(); }

// The plain sum over the vectors with all of |n_a| ≤ counts[a] whose length all directions hold completely.
std::unique_ptr<Reciprocal> make_plain_sum(double alpha, const std::array<std::int32_t, 3>& counts);

// Smooth particle mesh: counts are mesh points, order that of the splines (even).
std::unique_ptr<Reciprocal> make_mesh_sum(double alpha, const std::array<std::int32_t, 3>& counts, int order);

}  // namespace dlpoly::charge
