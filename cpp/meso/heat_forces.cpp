// What internal temperatures change of the pair forces (see heat_forces.hpp).
#include "meso/heat_forces.hpp"

#include <array>

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

namespace {

HeatBatch lanes_of(const PairBatch& batch) {
    return {batch.i.values, batch.j.values, batch.distance_squared.values,
            (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes};
}

}  // namespace

void HeatForces::change_conservative(const PairBatch& batch, BatchResult& result) const {
    if (!pairs_->scaled_repulsion) {
        return;
    }
    std::array<double, batch_capacity + batch_lanes> factor;
    loops_->repulsion({lanes_of(batch), beads_.data(), pairs_->reference(), factor.data()});
    for (std::size_t k = 0; k < batch.size; ++k) {
        result.energy.values[k] *= factor[k];
        result.conservative.values[k] *= factor[k];
    }
}

void HeatForces::change_curvature(const PairBatch& batch, double* curvature) const {
    if (!pairs_->scaled_repulsion) {
        return;
    }
    std::array<double, batch_capacity + batch_lanes> factor;
    loops_->repulsion({lanes_of(batch), beads_.data(), pairs_->reference(), factor.data()});
    for (std::size_t k = 0; k < batch.size; ++k) {
        curvature[k] *= factor[k];
    }
}

void HeatForces::change_motion(const PairBatch& batch, BatchResult& result, const PairDrag& drag,
                               const ForceRequest& request) const {
    const std::uint32_t term = batch.term;
    const std::size_t changes = (pairs_->weight_varies(term) ? 1U : 0U) + (pairs_->drag_varies(term) ? 2U : 0U);
    loops_->motion[changes]({lanes_of(batch), beads_.data(), &pairs_->at(term), pairs_->reference(),
                             pairs_->weight_exponent(), request.weight_exponent, drag.cutoff, result.drag.values,
                             result.noise.values});
}

}  // namespace dlpoly
