// The bonded terms of a scene and their exact sums on beads and over the system.
//
// Every term's forces are rounded once to a grid and added as integers, so that results are the same bits for any
// number of threads. The forces of a term add up to exactly zero.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "bonded/term_list.hpp"
#include "core/box.hpp"
#include "core/particles.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly {

// Sums over all terms of each kind. Virial tensors hold Σ F_a r_b, as those of the pairs do.
struct BondedTotals {
    std::array<double, bonded::components> energy{};
    std::array<Matrix3, bonded::components> virial{};

    BondedTotals() { virial.fill(Matrix3::Zero()); }
};

class BondedForces {
  public:
    // frozen: one flag a bead; terms between frozen beads alone are left out. thermal_energy only chooses the grid.
    BondedForces(std::vector<std::uint8_t> frozen, double thermal_energy);

    // Adds terms of one law and one set of parameters; `beads` has the term's beads one after the other.
    // Throws std::invalid_argument for unknown laws, bad parameters and beads that do not exist or repeat.
    void add(bonded::Kind kind, std::string_view key, std::span<const double> parameters,
             std::span<const std::uint32_t> beads);

    // Where tethers hold their beads: one position a bead.
    void set_anchors(Array3N anchors);

    // A pair that feels its pair law times `scale`, without drag and noise.
    void add_scaled_pair(std::uint32_t i, std::uint32_t j, double scale);

    [[nodiscard]] std::size_t beads() const noexcept { return frozen_.size(); }
    // One past the largest bead of any term.
    [[nodiscard]] std::uint32_t bead_end() const noexcept { return bead_end_; }
    // The grid for energies that add_to begins with.
    [[nodiscard]] int energy_exponent() const noexcept;
    [[nodiscard]] bool empty() const noexcept { return lists_.empty() && scaled_.empty(); }

    // For the general path: adds to particles.force and, when `totals` is given, writes what the terms add up to.
    // Throws RunFailure naming the beads of a term that is longer than half the box or not finite.
    void add_to(const Box& box, Particles& particles, const PairTable& pairs, std::uint64_t step, BondedTotals* totals);

    // Σ ∂²U/∂x² over the coordinates of all mobile beads; not a number when a term cannot be computed.
    [[nodiscard]] double curvature(const Box& box, const Particles& particles, const PairTable& pairs) const;

    // Shows the visitor every term at the present positions. Throws RunFailure as add_to does.
    void visit(const Box& box, const Particles& particles, const PairTable& pairs, std::uint64_t step,
               bonded::TermVisitor& visitor);

    // For any other path. prepare() shares the beads out among `parts` threads. Then each thread p calls part(p) with a
    // worker of its own that adds to the same sums (3 a bead, by id); after all of them, one thread calls part(parts)
    // for the terms that cross the borders. Positions are 3 numbers a bead, by id, in any image.
    void prepare(std::size_t parts);
    void part(std::size_t p, const bonded::MinimumImage& image, const double* positions,
              std::span<const std::int32_t> species, const PairTable& pairs, bonded::Worker& worker) const;
    // Throws RunFailure when one of the workers met a term that cannot be computed.
    static void report(std::span<const bonded::Worker> workers, const bonded::MinimumImage& image, std::uint64_t step);
    // What the workers have added up, for the energy scale of their requests.
    static BondedTotals total(std::span<const bonded::Worker> workers, int energy_exponent);

  private:
    struct ScaledPair {
        std::uint32_t i, j;
        double scale;
    };

    void scaled_pair(const ScaledPair& pair, const bonded::Places& places, std::span<const std::int32_t> species,
                     const PairTable& pairs, bonded::Worker& worker) const;
    [[nodiscard]] std::size_t part_of(std::uint32_t bead) const;

    std::vector<std::uint8_t> frozen_;
    double thermal_energy_;
    bonded::Magnitude largest_;
    double pair_force_ = -1.0;  // of the scaled pairs; negative: not known, or there are none
    std::vector<std::unique_ptr<bonded::TermList>> lists_;
    std::vector<ScaledPair> scaled_;
    Array3N anchors_;
    std::vector<std::uint32_t> bounds_;  // beads bounds_[p] … bounds_[p + 1] belong to part p
    std::vector<std::int64_t> sums_;
    std::uint32_t bead_end_ = 0;
};

}  // namespace dlpoly
