// What a force evaluation is asked for, and what one thread keeps while it walks the pairs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/exact_sum.hpp"
#include "core/types.hpp"
#include "forces/pair_batch.hpp"

namespace dlpoly {

// What one force evaluation is asked for.
struct ForceRequest {
    bool observe = false;          // also energies and stress
    bool always_observed = false;  // every step of the run is
    bool conservative = true;
    bool drag = false;   // also drag, from the velocities given
    bool noise = false;  // also this step's noise
    double weight_exponent = 2.0;
    double inverse_root_timestep = 0.0;  // 1/√Δt
    double noise_factor = 1.0;           // √(T/T₀) where the temperature varies; the table's σ belongs to T₀
    bool gaussian_noise = false;         // one Philox4x32-10 a pair instead of the mix of two beads' words
    std::uint64_t seed = 0;
    std::uint64_t step = 0;
    double time = 0.0;        // ps; for fields that vary
    double shear_rate = 0.0;  // of the cell, 1/ps: drag acts on velocities relative to the flow
};

// What one thread owns while it walks rows of the pair list: a batch, partial totals and the worst pair it met.
struct PairWorker {
    PairBatch batch;
    BatchResult result;
    std::int64_t accepted = 0;  // pairs within their reach
    WideSum energy;
    WideSum curvature;
    bool curvature_lost = false;
    std::array<std::array<WideSum, 6>, 3> virial;  // conservative, drag, noise; xx xy xz yy yz zz
    // Largest force term and largest energy or virial term met, in units of the largest term allowed; from 1 on the
    // sums must be repeated on a coarser grid. Smaller ones are not kept. Apart, so that observing a step never changes
    // its forces.
    double largest = 0.0;
    double largest_energy = 0.0;
    std::uint32_t largest_i = 0, largest_j = 0;
    double largest_distance = 0.0;

    void reset() {
        batch.size = 0;
        batch.runs = 0;
        accepted = 0;
        energy = curvature = WideSum();
        curvature_lost = false;
        virial = {};
        largest = 0.0;
        largest_energy = 0.0;
    }
};

// Is shown all pairs in one walk, batch by batch, with the conservative factor of each pair's vector r_i − r_j; `order`
// turns the batch's sorted indices into ids. Called by several threads at once, each with its number; threads that are
// called at the same time are shown pairs that share no bead.
class PairVisitor {
  public:
    PairVisitor() = default;
    PairVisitor(const PairVisitor&) = delete;
    PairVisitor& operator=(const PairVisitor&) = delete;
    PairVisitor(PairVisitor&&) = delete;
    PairVisitor& operator=(PairVisitor&&) = delete;
    virtual ~PairVisitor() = default;

    // Visitors that only look at distances are given no factors, and also pairs that have no conservative law.
    [[nodiscard]] virtual bool wants_factors() const { return true; }
    // The square of the distance within which it is shown pairs of an entry of the table, at most the table's own.
    [[nodiscard]] virtual double reach_squared(std::uint32_t /*term*/, double of_table) const { return of_table; }
    virtual void visit(const PairBatch& batch, const double* factors, const std::uint32_t* order, int thread) = 0;
};

// The same with the factors of drag and noise, for pairs that have a drag.
class MotionVisitor {
  public:
    MotionVisitor() = default;
    MotionVisitor(const MotionVisitor&) = delete;
    MotionVisitor& operator=(const MotionVisitor&) = delete;
    MotionVisitor(MotionVisitor&&) = delete;
    MotionVisitor& operator=(MotionVisitor&&) = delete;
    virtual ~MotionVisitor() = default;

    // Called once, before the pairs of a walk: how the batches are sorted, the velocities and the request that drag and
    // noise are found for, and how many threads there will be.
    virtual void begin(const std::vector<std::uint32_t>& order, const Array3N& velocity, const ForceRequest& request,
                       int threads) = 0;
    virtual void visit(const PairBatch& batch, const BatchResult& result, int thread) = 0;
};

// What is the same for all pairs of one walk.
struct PairWalk {
    ForceRequest request;
    bool motion = false;             // drag and noise act
    bool forces = true;              // else second derivatives of the energy, or what a visitor makes of the pairs
    PairVisitor* visitor = nullptr;  // nullptr: second derivatives
    MotionVisitor* motion_visitor = nullptr;
    const std::uint8_t* frozen = nullptr;  // by id; for the curvature
    double scale = 0.0;
    double energy_scale = 0.0;
    int threads = 1;
};

}  // namespace dlpoly
