// What internal temperatures change of the pair forces (see heat_forces.hpp).
#include "meso/heat_forces.hpp"

#include <cmath>

#include "forces/pair_forces.hpp"

namespace dlpoly {

void HeatForces::prepare(PairForces& pairs, const Box& /*box*/, const Particles& particles,
                         [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = pairs.order();
    beads_.resize(order.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::uint32_t id = order[k];
        beads_[k] = {particles.temperature[id], pairs_->held[id] != 0 ? 0.0 : 1.0 / particles.heat_capacity[id]};
    }
}

void HeatForces::change_conservative(const PairBatch& batch, BatchResult& result) const {
    if (!pairs_->scaled_repulsion) {
        return;
    }
    for (std::size_t k = 0; k < batch.size; ++k) {
        const double factor = mean(batch, k) / pairs_->reference();
        result.energy.values[k] *= factor;
        result.conservative.values[k] *= factor;
    }
}

void HeatForces::change_curvature(const PairBatch& batch, double* curvature) const {
    if (!pairs_->scaled_repulsion) {
        return;
    }
    for (std::size_t k = 0; k < batch.size; ++k) {
        curvature[k] *= mean(batch, k) / pairs_->reference();
    }
}

void HeatForces::change_motion(const PairBatch& batch, BatchResult& result, const PairDrag& drag,
                               const ForceRequest& request) const {
    const std::uint32_t term = batch.term;
    const bool weight_varies = pairs_->weight_varies(term);
    const bool drag_varies = pairs_->drag_varies(term);
    for (std::size_t k = 0; k < batch.size; ++k) {
        const Bead& one = beads_[batch.i.values[k]];
        const Bead& other = beads_[batch.j.values[k]];
        const double a = one.temperature;
        const double b = other.temperature;
        const double average = 0.5 * (a + b);
        const double closeness = 1.0 - std::sqrt(batch.distance_squared.values[k]) / drag.cutoff;
        double factor = 1.0;  // of γ w^D
        if (drag_varies) {
            factor = pairs_->drag_factor(term, average);
        }
        if (weight_varies) {
            const double change = pairs_->weight_exponent(term, average) - request.weight_exponent;
            // Outside the drag's own range both are 0 already, and so close to it that the power overflows.
            factor *= closeness > 0.0 ? std::pow(closeness, change) : 0.0;
            factor = std::isfinite(factor) ? factor : 0.0;
        }
        result.drag.values[k] *=
            factor * (1.0 + pairs_->drag_of_noise(term, a, b, one.inverse_capacity, other.inverse_capacity, closeness));
        result.noise.values[k] *= std::sqrt(factor * HeatPairs::thermal_energy(a, b) / pairs_->reference());
    }
}

}  // namespace dlpoly
