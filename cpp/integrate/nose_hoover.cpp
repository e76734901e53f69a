// The Nosé–Hoover thermostat (see nose_hoover.hpp).
#include "integrate/nose_hoover.hpp"

#include <cmath>

#include "integrate/moves.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

double wanted_energy(const State& state, const StepSettings& settings) {
    return static_cast<double>(settings.degrees_of_freedom) * thermal_energy_now(state, settings);
}

// Half a step of χ, of the velocities' friction and of the integral.
void half_step(State& state, const StepSettings& settings) {
    const double wanted = wanted_energy(state, settings);
    const double inertia = wanted * settings.relaxation * settings.relaxation;
    if (!(inertia > 0.0)) {
        return;
    }
    const double half = 0.5 * settings.timestep;
    Particles& particles = state.particles;
    double& friction = state.thermostat[0];
    double twice_kinetic = kinetic_tensor(particles).trace();
    friction += 0.5 * half * (twice_kinetic - wanted) / inertia;
    const double factor = std::exp(-friction * half);
    particles.velocity *= factor;
    twice_kinetic *= factor * factor;
    state.thermostat[1] += friction * half;
    friction += 0.5 * half * (twice_kinetic - wanted) / inertia;
}

}  // namespace

double thermostat_energy(const State& state, const StepSettings& settings) {
    if (settings.order != Order::hoover || state.thermostat.size() < 2) {
        return 0.0;
    }
    const double wanted = wanted_energy(state, settings);
    const double inertia = wanted * settings.relaxation * settings.relaxation;
    return 0.5 * inertia * state.thermostat[0] * state.thermostat[0] + wanted * state.thermostat[1];
}

void NoseHoover::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    half_step(state, settings);
    kick(particles, 0.5 * settings.timestep);
    constrain_drift(state, forces, settings.timestep);
    drift(state, settings, settings.timestep);
    advance_clock(state, settings);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    kick(particles, 0.5 * settings.timestep);
    constrain_velocities(state, forces, settings);
    half_step(state, settings);
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
