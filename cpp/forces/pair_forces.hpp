// The pair loop: link cells, pair laws, drag and noise, and their exact sums on beads and over the system.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cells/link_cells.hpp"
#include "core/box.hpp"
#include "core/exact_sum.hpp"
#include "core/particles.hpp"
#include "forces/exclusions.hpp"
#include "forces/pair_table.hpp"
#include "forces/pair_worker.hpp"

namespace dlpoly {

// Sums over all pairs. Virial tensors hold Σ F_a (r_i − r_j)_b, so that the stress they add is this over the volume.
struct PairTotals {
    double energy = 0.0;
    Matrix3 conservative = Matrix3::Zero();
    Matrix3 drag = Matrix3::Zero();
    Matrix3 noise = Matrix3::Zero();
};

class PairForces {
  public:
    // thermal_energy and timestep only choose the grid of the exact sums.
    PairForces(PairTable table, double thermal_energy, double timestep);

    // Cells at least this wide instead of one range wide; 0 = one range. Changes speed, never results.
    void set_cell_width(double width) noexcept { cell_width_ = width; }

    // Pairs that are left out, with their drag and noise.
    void set_exclusions(Exclusions exclusions) { exclusions_ = std::move(exclusions); }
    [[nodiscard]] bool has_exclusions() const noexcept { return !exclusions_.empty(); }

    // Writes the pair force on every bead to particles.force (frozen beads: zero). Drag uses `velocity`.
    // Throws RunFailure when a pair's force is not finite, naming both beads.
    void compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                 PairTotals& totals);

    [[nodiscard]] const PairTable& table() const noexcept { return table_; }
    [[nodiscard]] const LinkCells& cells() const noexcept { return cells_; }

  private:
    void gather(const Particles& particles, const Array3N& velocity, const ForceRequest& request);
    struct Largest {
        double force = 0.0;
        double energy = 0.0;
    };

    [[nodiscard]] Largest visit_pairs(const Box& box, const ForceRequest& request, int exponent, int energy_exponent);
    void search_row(const Box& box, std::int32_t row, PairWorker& worker);
    void search_cell_pair(std::uint32_t i_begin, std::uint32_t i_end, std::uint32_t j_begin, std::uint32_t j_end,
                          bool same_cell, const Vector3& shift, std::uint8_t image_ij, std::uint8_t image_ji,
                          PairWorker& worker);
    void flush(std::size_t kind, PairWorker& worker);
    void evaluate_drag(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const;
    // Whether the pair of these sorted indices is left out.
    [[nodiscard]] bool excluded(std::uint32_t i, std::uint32_t j) const noexcept {
        return !exclusions_.empty() && exclusions_.contains(cells_.order()[i], cells_.order()[j]);
    }
    [[noreturn]] void report_overflow(const PairWorker& worst) const;

    PairTable table_;
    Exclusions exclusions_;
    LinkCells cells_;
    double cell_width_ = 0.0;
    int base_exponent_;
    int base_energy_exponent_;

    // Beads in cell order.
    std::vector<double> x_, y_, z_;
    std::vector<double> vx_, vy_, vz_;
    std::vector<std::uint32_t> words_;
    std::vector<std::int32_t> species_;
    std::vector<std::uint8_t> frozen_;
    bool any_frozen_ = false;
    std::vector<std::int64_t> sums_;  // 3 a bead, grid units
    std::vector<PairWorker> workers_;
};

}  // namespace dlpoly
