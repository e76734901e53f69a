// What internal temperatures change of the pair forces: drag and noise of force-based integrators, and a repulsion that
// grows with the temperature.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "forces/pair_modifier.hpp"
#include "forces/weight_loops.hpp"
#include "meso/heat_pairs.hpp"

namespace dlpoly {

class HeatForces final : public PairModifier {
  public:
    // The noise of the pair table must be that of the reference temperature.
    explicit HeatForces(std::shared_ptr<const HeatPairs> pairs) : pairs_(std::move(pairs)), weights_(&weight_loops()) {}

    void prepare(PairForces& pairs, const Box& box, const Particles& particles, int threads) override;
    void change_conservative(const PairBatch& batch, BatchResult& result) const override;
    [[nodiscard]] bool changes_motion() const override { return true; }
    void change_motion(const PairBatch& batch, BatchResult& result, const PairDrag& drag,
                       const ForceRequest& request) const override;
    void change_curvature(const PairBatch& batch, double* curvature) const override;

  private:
    struct Bead {
        double temperature;
        double inverse_capacity;  // 0 where the temperature is held
    };

    [[nodiscard]] double mean(const PairBatch& batch, std::size_t k) const noexcept {
        return 0.5 * (beads_[batch.i.values[k]].temperature + beads_[batch.j.values[k]].temperature);
    }

    std::shared_ptr<const HeatPairs> pairs_;
    const WeightLoops* weights_;
    std::vector<Bead> beads_;  // sorted
};

}  // namespace dlpoly
