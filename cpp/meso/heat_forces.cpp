// What internal temperatures change of the pair forces (see heat_forces.hpp).
#include "meso/heat_forces.hpp"

#include <array>
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
    using Lanes = std::array<double, batch_capacity + batch_lanes>;
    const std::uint32_t term = batch.term;
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    Lanes average;
    Lanes weight;  // w^D over that of the table's exponent
    weight.fill(1.0);
    Lanes logarithm;  // of 1 − r/r_c
    logarithm.fill(0.0);
    for (std::size_t k = 0; k < whole; ++k) {
        average[k] = mean(batch, k);
    }
    if (pairs_->weight_varies(term)) {
        Lanes change;
        for (std::size_t k = 0; k < whole; ++k) {
            change[k] = pairs_->weight_exponent(term, average[k]) - request.weight_exponent;
        }
        // Outside the drag's own range drag and noise are 0 already.
        weights_->each(batch.distance_squared.values, drag.cutoff, change.data(), weight.data(), logarithm.data(),
                       whole);
    }
    const double unit = 1.0 / pairs_->reference();
    const bool drag_varies = pairs_->drag_varies(term);
    for (std::size_t k = 0; k < whole; ++k) {
        const Bead& one = beads_[batch.i.values[k]];
        const Bead& other = beads_[batch.j.values[k]];
        const double a = one.temperature;
        const double b = other.temperature;
        const double factor = drag_varies ? weight[k] * pairs_->drag_factor(term, average[k]) : weight[k];
        result.drag.values[k] *= factor * (1.0 + pairs_->drag_of_noise(term, a, b, one.inverse_capacity,
                                                                       other.inverse_capacity, logarithm[k]));
        result.noise.values[k] *= std::sqrt(factor * HeatPairs::thermal_energy(a, b) * unit);
    }
}

}  // namespace dlpoly
