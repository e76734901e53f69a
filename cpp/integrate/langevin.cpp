// Langevin dynamics (see langevin.hpp).
#include "integrate/langevin.hpp"

#include <cmath>

#include "core/random.hpp"
#include "integrate/moves.hpp"
#include "integrate/piston.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

void thermalise(State& state, const StepSettings& settings) {
    Particles& particles = state.particles;
    const double keep = std::exp(-settings.thermostat_friction * settings.timestep);
    const double energy =
        thermal_energy_now(state, settings) * -std::expm1(-2.0 * settings.thermostat_friction * settings.timestep);
    const Eigen::Index beads = particles.count();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        const auto id = static_cast<std::uint32_t>(i);
        const auto xy = gaussian_pair(draw(settings.seed, Stream::thermostat, state.step, id, 0));
        const double z = gaussian(draw(settings.seed, Stream::thermostat, state.step, id, 1));
        const double width = std::sqrt(energy * particles.inverse_mass(i));
        particles.velocity.row(i) = keep * particles.velocity.row(i) + width * Vector3(xy[0], xy[1], z).transpose();
    }
}

}  // namespace

void Langevin::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    push_piston(state, forces, totals, settings, 0.5 * settings.timestep);
    kick(state, settings, 0.5 * settings.timestep);
    constrain_drift(state, forces, 0.5 * settings.timestep);
    drift(state, settings, 0.5 * settings.timestep);
    advance_clock(state, settings);
    enter_middle(state, settings);
    thermalise(state, settings);
    constrain_velocities(state, forces, settings);
    std::optional<Matrix3> kinetic;
    if (observe) {
        kinetic = kinetic_tensor(particles);
    }
    leave_middle(state, settings);
    constrain_drift(state, forces, 0.5 * settings.timestep);
    drift(state, settings, 0.5 * settings.timestep);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    totals.kinetic = kinetic;
    kick(state, settings, 0.5 * settings.timestep);
    constrain_velocities(state, forces, settings);
    push_piston(state, forces, totals, settings, 0.5 * settings.timestep);
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
