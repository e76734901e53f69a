// Drag and noise of the pair loop (see pair_forces.hpp).
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/random.hpp"
#include "forces/pair_forces.hpp"

namespace dlpoly {

// Turns drag of the weight (1 − r/r_c)² and noise of its root into those of the exponent s.
void PairForces::change_weights(const PairBatch& batch, BatchResult& result, double cutoff, double exponent) const {
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    std::array<double, batch_capacity + batch_lanes> change;
    weights_->common(batch.distance_squared.values, cutoff, 0.5 * exponent - 1.0, change.data(), whole);
    for (std::size_t k = 0; k < whole; ++k) {
        result.drag.values[k] *= change[k] * change[k];
        result.noise.values[k] *= change[k];
    }
}

// Drag and noise of a batch: −γ w^D (e·v_ij) e and σ w^R ζ/√Δt e with w^R = √w^D, Español and Warren (1995).
void PairForces::evaluate_motion(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const {
    PairDrag pair = table_.drags()[batch.term];
    pair.drag = request.drag ? pair.drag : 0.0;
    pair.noise = request.noise ? pair.noise * request.noise_factor : 0.0;
    const std::vector<std::uint32_t>& order = list_.order();
    const auto* codes = list_.image_codes().empty() ? nullptr : list_.image_codes().data();
    if (!request.gaussian_noise) {
        const MotionArguments arguments{
            motion_.data(), codes, order.data(), pair.drag, pair.noise, request.inverse_root_timestep, pair.cutoff};
        phases_->motion(arguments, batch, result);
        if (request.weight_exponent != 2.0) {
            change_weights(batch, result, pair.cutoff, request.weight_exponent);
        }
        return;
    }
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    for (std::size_t k = 0; k < whole; ++k) {
        const std::uint32_t i = batch.i.values[k];
        const std::uint32_t j = batch.j.values[k];
        result.drag.values[k] = 0.0;
        result.noise.values[k] = 0.0;
        const double squared = batch.distance_squared.values[k];
        const double distance = std::sqrt(squared);
        // A bead and its own image, and coincident beads, define no direction that could be damped.
        if (!(distance < pair.cutoff) || distance == 0.0 || i == j) {
            continue;
        }
        const double closeness = 1.0 - distance / pair.cutoff;
        const double weight =
            request.weight_exponent == 2.0 ? closeness : std::pow(closeness, 0.5 * request.weight_exponent);
        const double projection = batch.dx.values[k] * (motion_[i].x - motion_[j].x) +
                                  batch.dy.values[k] * (motion_[i].y - motion_[j].y) +
                                  batch.dz.values[k] * (motion_[i].z - motion_[j].z);
        result.drag.values[k] = -pair.drag * weight * weight * projection / squared;
        if (pair.noise > 0.0) {
            const bool forward = order[i] < order[j];
            const std::uint8_t image =
                codes == nullptr ? std::uint8_t{0} : codes[batch.image.values[k]].code[forward ? 0 : 1];
            const double zeta = pair_noise(request.seed, request.step, order[i], order[j], image);
            result.noise.values[k] = pair.noise * weight * zeta * request.inverse_root_timestep / distance;
        }
    }
}

// The drag of the flow in a sheared cell. The batch's drag is that of velocities relative to the flow, which are the
// same for all images of a bead; the flow itself differs by rate · (y_i − y_j) between a bead and the image it meets.
void PairForces::add_drag_of_shear(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const {
    const PairDrag& pair = table_.drags()[batch.term];
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    for (std::size_t k = 0; k < whole; ++k) {
        const double squared = batch.distance_squared.values[k];
        const double distance = std::sqrt(squared);
        if (!(distance < pair.cutoff) || distance == 0.0 || batch.i.values[k] == batch.j.values[k]) {
            continue;
        }
        const double closeness = 1.0 - distance / pair.cutoff;
        const double weight =
            request.weight_exponent == 2.0 ? closeness * closeness : std::pow(closeness, request.weight_exponent);
        const double projection = request.shear_rate * batch.dx.values[k] * batch.dy.values[k];
        result.drag.values[k] -= pair.drag * weight * projection / squared;
    }
}

}  // namespace dlpoly
