// The electrostatics of a scene: pairs within the cutoff, the sum over reciprocal vectors where the method has one, and
// what becomes of excluded and 1-4 pairs. Only charged beads are looked at.
//
// Forces are rounded once to a grid and added as integers; sums over reciprocal vectors have a fixed order. Results are
// the same bits for any number of threads, and the forces on all charges add up to exactly zero.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "charge/accumulator.hpp"
#include "charge/charges.hpp"
#include "charge/kernel.hpp"
#include "charge/method.hpp"
#include "charge/pair_sum.hpp"
#include "charge/reciprocal.hpp"
#include "charge/special_pairs.hpp"
#include "core/box.hpp"
#include "core/particles.hpp"
#include "forces/exclusions.hpp"

namespace dlpoly {

// What the electrostatics of a scene are made from.
struct ChargeSettings {
    std::string method = "ewald";  // a name of charge/registry.hpp
    std::string shape = "point";
    double length = 1.0;    // of the shape
    double strength = 1.0;  // energy times length of two unit charges
    charge::MethodNumbers numbers;
    std::array<std::int32_t, 3> counts{};  // reciprocal vectors along each axis, or points of the mesh
    int order = 0;                         // of the mesh's splines; 0: the plain sum
};

// Sums over all charges; the virial tensor holds Σ F_a r_b.
struct ChargeTotals {
    double energy = 0.0;
    Matrix3 virial = Matrix3::Zero();
};

class ChargeForces {
  public:
    struct ScaledPair {
        std::uint32_t i, j;  // ids
        double scale;
    };

    // charges and frozen flags of all beads; those without charge are left out at once. `excluded` and `scaled` are
    // pairs of ids, the second among the first. Throws std::invalid_argument for settings that have no meaning.
    ChargeForces(std::span<const double> charges, std::span<const std::uint8_t> frozen, ChargeSettings settings,
                 std::span<const std::pair<std::uint32_t, std::uint32_t>> excluded, std::span<const ScaledPair> scaled);

    [[nodiscard]] const charge::Charges& charges() const noexcept { return charges_; }

    // For the general path: adds to particles.force and, when `totals` is given, writes what the charges add up to.
    // Throws RunFailure naming two beads whose force is not finite.
    void add_to(const Box& box, Particles& particles, std::uint64_t step, ChargeTotals* totals);

    // For any other path: forces on the charges in grid units along each axis, as rounded by `scale`. Positions are one
    // charge a row, wrapped. Returns nullptr when a force is beyond the grid.
    const std::vector<std::int64_t>* compute(const Box& box, const Array3N& positions, const Vector3& scale,
                                             std::uint64_t step, ChargeTotals* totals);

    // Σ ∂²U/∂x² over the coordinates of all mobile beads; not a number when it cannot be computed.
    [[nodiscard]] double curvature(const Box& box, const Particles& particles);

  private:
    [[nodiscard]] Array3N positions_of(const Particles& particles) const;
    // Pair terms and special pairs; repeated on a coarser grid of energies where need be.
    charge::Accumulator walk(const Box& box, const Array3N& positions, const Vector3& scale, std::uint64_t step,
                             ChargeTotals* totals);
    void add_reciprocal(const Box& box, const Array3N& positions, ChargeTotals* totals);
    [[nodiscard]] bool round_reciprocal(const Vector3& scale);
    [[nodiscard]] ChargeTotals frozen_alone(const Box& box, const Array3N& positions);
    [[nodiscard]] double background(const Box& box) const;
    void report(const charge::Failure& failure, std::uint64_t step) const;

    ChargeSettings settings_;
    charge::Charges charges_;
    bool any_frozen_ = false;
    double self_ = 0.0;            // −α/√π Σ q² over the mobile charges
    double total_ = 0.0;           // Σ q of all charges
    double total_frozen_ = 0.0;    // of the frozen ones
    double characteristic_ = 0.0;  // of a force
    std::unique_ptr<charge::Kernel> kernel_;
    std::unique_ptr<charge::Kernel> bare_;  // what 1-4 pairs feel
    std::unique_ptr<Exclusions> excluded_;  // by place in the list of charges
    std::unique_ptr<charge::PairSum> pairs_;
    std::unique_ptr<charge::SpecialPairs> special_;
    std::unique_ptr<charge::Reciprocal> reciprocal_;
    std::vector<std::int64_t> sums_;
    Array3N smooth_;  // forces of the sum over reciprocal vectors
};

}  // namespace dlpoly
