// A part of the pair forces that needs to know more of two beads than their distance: a local density, an internal
// temperature. Scenes without one walk their pairs as if this did not exist.
#pragma once

#include <cstdint>
#include <span>

#include "core/box.hpp"
#include "core/particles.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_table.hpp"
#include "forces/pair_worker.hpp"

namespace dlpoly {

class PairForces;

class PairModifier {
  public:
    PairModifier() = default;
    PairModifier(const PairModifier&) = delete;
    PairModifier& operator=(const PairModifier&) = delete;
    PairModifier(PairModifier&&) = delete;
    PairModifier& operator=(PairModifier&&) = delete;
    virtual ~PairModifier() = default;

    // Before the pairs of one evaluation are walked: gathers what belongs to beads, in the order of pairs.order(). May
    // walk the pairs itself, by pairs.show(). `threads` is how many the walk will have. Left out where the evaluation
    // asks for drag and noise alone and the part changes neither.
    virtual void prepare(PairForces& pairs, const Box& box, const Particles& particles, int threads) = 0;

    // Changes energy and conservative factor of every pair of a batch, up to whole lanes.
    virtual void change_conservative(const PairBatch& batch, BatchResult& result) const = 0;

    // Whether drag and noise of a pair are not those of the table alone; they are then changed by change_motion, which
    // finds what the table and the request make of them; where it also gives the pairs of a term weights of its own,
    // those of the exponent 2, which the request then says.
    [[nodiscard]] virtual bool changes_motion() const { return false; }
    [[nodiscard]] virtual bool changes_weight(std::uint32_t /*term*/) const { return false; }
    virtual void change_motion(const PairBatch& /*batch*/, BatchResult& /*result*/, const PairDrag& /*drag*/,
                               const ForceRequest& /*request*/) const {}

    // Energy of the last prepared evaluation that belongs to beads and not to pairs.
    [[nodiscard]] virtual double energy() const { return 0.0; }

    // Changes ∇²U of every pair of a batch with respect to one of its beads; and Σ ∂²U/∂x² over the mobile beads of
    // what cannot be said pair by pair, for the last prepared evaluation.
    virtual void change_curvature(const PairBatch& /*batch*/, double* /*curvature*/) const {}
    [[nodiscard]] virtual double curvature(PairForces& /*pairs*/, const Box& /*box*/, const Particles& /*particles*/) {
        return 0.0;
    }

    // The largest force that beads meet; it only chooses the grid of the exact sums.
    [[nodiscard]] virtual double characteristic_force() const { return 0.0; }
};

}  // namespace dlpoly
