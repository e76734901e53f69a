// What internal temperatures change of the pair forces: drag and noise of force-based integrators, and a repulsion that
// grows with the temperature.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "forces/pair_modifier.hpp"
#include "meso/heat_motion_loops.hpp"
#include "meso/heat_pairs.hpp"

namespace dlpoly {

class HeatForces final : public PairModifier {
  public:
    // The noise of the pair table must be that of the reference temperature.
    explicit HeatForces(std::shared_ptr<const HeatPairs> pairs)
        : pairs_(std::move(pairs)), loops_(&heat_motion_loops()) {}

    void prepare(PairForces& pairs, const Box& box, const Particles& particles, int threads) override;
    void change_conservative(const PairBatch& batch, BatchResult& result) const override;
    [[nodiscard]] bool changes_motion() const override { return true; }
    [[nodiscard]] bool changes_weight(std::uint32_t term) const override { return pairs_->weight_varies(term); }
    void change_motion(const PairBatch& batch, BatchResult& result, const PairDrag& drag,
                       const ForceRequest& request) const override;
    void change_curvature(const PairBatch& batch, double* curvature) const override;

  private:
    std::shared_ptr<const HeatPairs> pairs_;
    const HeatMotionLoops* loops_;
    std::vector<HeatBead> beads_;  // sorted
};

}  // namespace dlpoly
