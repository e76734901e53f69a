// Heat from drag and noise that are forces (see viscous_heating.hpp).
#include "meso/viscous_heating.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/failure.hpp"
#include "integrate/moves.hpp"

namespace dlpoly {

void ViscousHeating::begin(const std::vector<std::uint32_t>& order, int threads) {
    order_ = order;
    parts_.assign(static_cast<std::size_t>(threads), {});
    sums_.assign(order.size(), 0);
    beads_.resize(order.size());
    const Particles& particles = *particles_;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < order.size(); ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        beads_[k] = {velocity_->row(id).transpose(),
                     0.5 * timestep_ * particles.inverse_mass(id) * particles.force.row(id).transpose(),
                     particles.mass[order[k]], particles.heat_capacity[order[k]], particles.temperature[order[k]]};
    }
}

ViscousHeating::Work ViscousHeating::work(const PairBatch& batch, const BatchResult& result, std::size_t k) const {
    const Bead& a = beads_[batch.i.values[k]];
    const Bead& b = beads_[batch.j.values[k]];
    const Vector3 apart(batch.dx.values[k], batch.dy.values[k], batch.dz.values[k]);
    const double before = apart.dot(a.before - b.before);
    const double drag = result.drag.values[k];
    const double noise = result.noise.values[k];
    if (form_ == Form::lammps) {
        // γ w^D is −drag r²/(r·v), unless the pair does not move: then noise, whose mean square is known, is left out.
        const double gamma = before != 0.0 ? -drag * batch.distance_squared.values[k] / before : 0.0;
        const double variance = 2.0 * gamma * HeatPairs::thermal_energy(a.thermal_energy, b.thermal_energy);
        const double power =
            -drag * before - variance / (0.5 * (a.mass + b.mass)) - noise * before * std::sqrt(timestep_);
        return {2.0 * timestep_ * power / (a.capacity + b.capacity), 0.0};
    }
    const double change = apart.dot(a.change - b.change);
    const double push = 0.5 * timestep_ * (drag + noise);
    const double ahead = push * (before + (kicked_ + 0.5) * change);  // over the velocities from v to v + change
    return {-push * (before + 0.5 * change) - ahead, ahead};
}

void ViscousHeating::visit(const PairBatch& batch, const BatchResult& result, int thread) {
    Part& part = parts_[static_cast<std::size_t>(thread)];
    for (std::size_t k = 0; k < batch.size; ++k) {
        const std::uint32_t i = batch.i.values[k];
        const std::uint32_t j = batch.j.values[k];
        if (i == j) {
            continue;
        }
        const Work done = work(batch, result, k);
        const double heat = 0.5 * done.heat * scale_;
        const double ahead = done.ahead * scale_;
        const double size = std::max(std::abs(heat), std::abs(ahead)) / largest_term;
        part.largest = std::max(part.largest, std::isfinite(size) ? size : HUGE_VAL);
        if (size < 1.0) {
            const std::int64_t whole = std::llrint(heat);
            sums_[i] += whole;
            sums_[j] += whole;
            part.ahead.add(std::llrint(ahead));
        }
    }
}

void ViscousHeating::walk(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity) {
    particles_ = &state.particles;
    velocity_ = &velocity;
    timestep_ = settings.timestep;
    const ForceRequest request = request_of(state, settings, false);
    // Heat is a multiple of k_B T for all but wild starts; the grid gets coarser until it fits.
    int exponent = grid_exponent(std::max(pairs_->reference(), 1e-200));
    for (bool fits = false; !fits;) {
        scale_ = std::ldexp(1.0, exponent);
        parts_.clear();
        forces.pairs().visit_motion(state.box, state.particles, velocity, request, *this);
        double largest = 0.0;
        for (const Part& part : parts_) {
            largest = std::max(largest, part.largest);
        }
        if (!std::isfinite(largest)) {
            throw RunFailure("step " + std::to_string(state.step) +
                             ": the heat of drag and noise is not finite; the timestep is too long for the drag");
        }
        fits = largest < 1.0;
        exponent -= fits ? 0 : std::ilogb(largest) + 1;
    }
    WideSum ahead;
    for (const Part& part : parts_) {
        ahead.add(part.ahead);
    }
    state.heat_ahead = ahead.value(static_cast<int>(std::lround(std::log2(scale_))));
}

void ViscousHeating::start(State& state, Forces& forces, const StepSettings& settings) {
    state.heat_ahead = 0.0;
    if (form_ != Form::conserving) {
        return;
    }
    // The drag is that of the present velocities. No bead is charged: only what the first half kick does is noted.
    kicked_ = 0.0;
    walk(state, forces, settings, state.particles.velocity);
    kicked_ = 1.0;
}

void ViscousHeating::advance(State& state, Forces& forces, const StepSettings& settings) {
    Particles& particles = state.particles;
    before_.resize(particles.count(), 3);
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        before_.row(i) =
            particles.velocity.row(i) - 0.5 * settings.timestep * particles.inverse_mass(i) * particles.force.row(i);
    }
    walk(state, forces, settings, before_);
    deposit(state);
}

void ViscousHeating::deposit(State& state) const {
    Particles& particles = state.particles;
    for (std::size_t k = 0; k < order_.size(); ++k) {
        const std::uint32_t id = order_[k];
        const double heat = static_cast<double>(sums_[k]) / scale_;
        if (pairs_->held[id] != 0) {
            state.heat_supplied -= heat;
            continue;
        }
        const double temperature = particles.temperature[id] + heat / particles.heat_capacity[id];
        if (!(temperature > 0.0)) {
            throw RunFailure("step " + std::to_string(state.step) + ": drag and noise take more heat from bead " +
                             std::to_string(id + 1) +
                             " than it has; the timestep is too long for its heat capacity, or take an integrator "
                             "that sweeps over pairs");
        }
        particles.temperature[id] = temperature;
    }
}

}  // namespace dlpoly
