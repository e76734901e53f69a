// SC-VV (see self_consistent.hpp).
#include "integrate/self_consistent.hpp"

#include <cmath>
#include <string>

#include "core/failure.hpp"
#include "integrate/moves.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

constexpr int most_iterations = 200;

}  // namespace

void SelfConsistent::step(State& state, Forces& forces, const StepSettings& settings, bool observe,
                          PairTotals& totals) {
    Particles& particles = state.particles;
    const double half = 0.5 * settings.timestep;
    kick(particles, half);
    drift(state, settings, settings.timestep);
    advance_clock(state, settings);
    halfway_ = particles.velocity;
    ForceRequest request = request_of(state, settings, observe);
    request.drag = false;
    compute_forces(state, forces, settings, request, particles.velocity, totals);
    others_ = particles.force;
    request.conservative = request.noise = request.observe = false;
    request.drag = true;
    PairTotals of_drag;
    double before = kinetic_tensor(particles).trace();
    double change = 0.0;
    int iteration = 0;
    do {
        forces.compute(state.box, particles, particles.velocity, request, of_drag);
        particles.force += others_;
        particles.velocity = halfway_;
        kick(particles, half);
        const double after = kinetic_tensor(particles).trace();
        change = std::abs(after - before);
        before = after;
        if (++iteration > most_iterations || !std::isfinite(after)) {
            throw RunFailure("step " + std::to_string(state.step) +
                             ": the velocities did not become consistent with "
                             "their drag in " +
                             std::to_string(most_iterations) + " iterations; the timestep is too long for the drag");
        }
    } while (change > settings.tolerance * before);
    request.observe = observe;
    forces.compute(state.box, particles, particles.velocity, request, of_drag);
    particles.force += others_;
    totals.drag = of_drag.drag;
    finish_step(state, settings);
}

}  // namespace dlpoly
