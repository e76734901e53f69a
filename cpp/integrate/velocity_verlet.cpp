// Velocity Verlet (see velocity_verlet.hpp).
#include "integrate/velocity_verlet.hpp"

#include <atomic>
#include <cmath>
#include <string>

#include "core/failure.hpp"
#include "integrate/equilibration.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

void kick(Particles& particles, double time) {
    const Eigen::Index beads = particles.count();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        particles.velocity.row(i) += time * particles.inverse_mass(i) * particles.force.row(i);
    }
}

void drift(State& state, double time) {
    Particles& particles = state.particles;
    const Eigen::Index beads = particles.count();
    std::atomic<Eigen::Index> lost{-1};
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        Vector3 position = (particles.position.row(i) + time * particles.velocity.row(i)).transpose();
        if (!state.box.wrap(position, particles.image.row(i).data())) {
            lost = i;
        } else {
            particles.position.row(i) = position.transpose();
        }
    }
    if (lost >= 0) {
        throw RunFailure("step " + std::to_string(state.step + 1) + ": bead " + std::to_string(lost + 1) +
                         " left all bounds or its position is not a number; the timestep is too long for the forces");
    }
}

}  // namespace

void VelocityVerlet::evaluate(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity,
                              bool observe, PairTotals& totals) {
    ForceRequest request;
    request.observe = observe;
    request.drag = settings.drag;
    request.weight_exponent = settings.weight_exponent;
    request.inverse_root_timestep = settings.drag ? 1.0 / std::sqrt(settings.timestep) : 0.0;
    request.gaussian_noise = settings.precision == Precision::reference;
    request.seed = settings.seed;
    request.step = state.step;
    forces.compute(state.box, state.particles, velocity, request, totals);
    if (settings.force_cap > 0.0 && state.step <= settings.equilibration_steps) {
        cap_forces(state.particles, settings.force_cap);
    }
}

void VelocityVerlet::start(State& state, Forces& forces, const StepSettings& settings, bool observe,
                           PairTotals& totals) {
    evaluate(state, forces, settings, state.particles.velocity, observe, totals);
}

void VelocityVerlet::step(State& state, Forces& forces, const StepSettings& settings, bool observe,
                          PairTotals& totals) {
    Particles& particles = state.particles;
    const double timestep = settings.timestep;
    const bool predict = settings.drag && settings.prediction != 0.5;
    if (predict) {
        predicted_ = particles.velocity;
        const Eigen::Index beads = particles.count();
        for (Eigen::Index i = 0; i < beads; ++i) {
            predicted_.row(i) += settings.prediction * timestep * particles.inverse_mass(i) * particles.force.row(i);
        }
    }
    kick(particles, 0.5 * timestep);
    drift(state, timestep);
    ++state.step;
    state.time += timestep;
    evaluate(state, forces, settings, predict ? predicted_ : particles.velocity, observe, totals);
    kick(particles, 0.5 * timestep);
    if (settings.remove_drift) {
        remove_drift(particles);
    }
    equilibrate(state, settings);
}

}  // namespace dlpoly
