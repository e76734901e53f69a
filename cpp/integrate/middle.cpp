// The simultaneous middle step (see middle.hpp).
#include "integrate/middle.hpp"

#include <algorithm>
#include <cmath>

#include "integrate/moves.hpp"
#include "integrate/piston.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void Middle::thermalise(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    const double duration = settings.timestep * settings.thermostat_every;
    ForceRequest request = request_of(state, settings, observe);
    request.conservative = request.drag = false;
    request.inverse_root_timestep = 1.0 / std::sqrt(duration);
    before_ = particles.velocity;
    forces.compute(state.box, particles, before_, request, totals);
    kick(particles, duration);
    noise_ = particles.velocity - before_;
    request.noise = false;
    request.drag = true;
    estimate_ = settings.passes == 1 ? before_ : before_ + 0.25 * noise_;
    PairTotals of_drag;
    for (int pass = 2; pass <= std::max(2, settings.passes); ++pass) {
        if (pass > 2) {
            estimate_ = 0.5 * (before_ + particles.velocity);
        }
        request.observe = observe && pass == std::max(2, settings.passes);
        forces.compute(state.box, particles, estimate_, request, of_drag);
        particles.velocity = before_ + noise_;
        kick(particles, duration);
    }
    totals.drag = of_drag.drag;
}

void Middle::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    PairTotals of_motion;
    push_piston(state, forces, totals, settings, 0.5 * settings.timestep);
    kick(state, settings, 0.5 * settings.timestep);
    constrain_drift(state, forces, 0.5 * settings.timestep);
    drift(state, settings, 0.5 * settings.timestep);
    advance_clock(state, settings);
    enter_middle(state, settings);
    if (settings.drag && state.step % static_cast<std::uint64_t>(settings.thermostat_every) == 0) {
        enter_thermostat(state, forces, settings);
        thermalise(state, forces, settings, observe, of_motion);
    }
    constrain_velocities(state, forces, settings);
    std::optional<Matrix3> kinetic;
    if (observe) {
        kinetic = kinetic_tensor(particles, settings.shear_rate);
    }
    leave_middle(state, settings);
    constrain_drift(state, forces, 0.5 * settings.timestep);
    drift(state, settings, 0.5 * settings.timestep);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    totals.drag = of_motion.drag;
    totals.noise = of_motion.noise;
    totals.kinetic = kinetic;
    kick(state, settings, 0.5 * settings.timestep);
    constrain_velocities(state, forces, settings);
    push_piston(state, forces, totals, settings, 0.5 * settings.timestep);
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
