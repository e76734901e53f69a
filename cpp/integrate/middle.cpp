// The simultaneous middle step (see middle.hpp).
#include "integrate/middle.hpp"

#include <cmath>

#include "integrate/moves.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void Middle::start(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), state.particles.velocity,
                   totals);
}

void Middle::thermalise(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    const double duration = settings.timestep * settings.thermostat_every;
    ForceRequest request = request_of(state, settings, false);
    request.conservative = false;
    request.inverse_root_timestep = 1.0 / std::sqrt(duration);
    before_ = particles.velocity;
    mean_ = particles.velocity;
    for (int pass = 0; pass < settings.passes; ++pass) {
        request.observe = observe && pass + 1 == settings.passes;
        forces.compute(state.box, particles, mean_, request, totals);
        particles.velocity = before_;
        kick(particles, duration);
        mean_ = 0.5 * (before_ + particles.velocity);
    }
}

void Middle::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    PairTotals of_motion;
    kick(particles, 0.5 * settings.timestep);
    drift(state, 0.5 * settings.timestep);
    advance_clock(state, settings);
    if (settings.drag && state.step % static_cast<std::uint64_t>(settings.thermostat_every) == 0) {
        thermalise(state, forces, settings, observe, of_motion);
    }
    std::optional<Matrix3> kinetic;
    if (observe) {
        kinetic = kinetic_tensor(particles);
    }
    drift(state, 0.5 * settings.timestep);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    totals.drag = of_motion.drag;
    totals.noise = of_motion.noise;
    totals.kinetic = kinetic;
    kick(particles, 0.5 * settings.timestep);
    finish_step(state, settings);
}

}  // namespace dlpoly
