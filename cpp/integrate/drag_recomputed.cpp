// DPD-VV (see drag_recomputed.hpp).
#include "integrate/drag_recomputed.hpp"

#include "integrate/moves.hpp"

namespace dlpoly {

void DragRecomputed::step(State& state, Forces& forces, const StepSettings& settings, bool observe,
                          PairTotals& totals) {
    Particles& particles = state.particles;
    kick(particles, 0.5 * settings.timestep);
    constrain_drift(state, forces, settings.timestep);
    drift(state, settings, settings.timestep);
    advance_clock(state, settings);
    ForceRequest request = request_of(state, settings, observe);
    request.drag = false;
    compute_forces(state, forces, settings, request, particles.velocity, totals);
    others_ = particles.force;
    request.conservative = request.noise = request.observe = false;
    request.drag = true;
    PairTotals of_drag;
    forces.compute(state.box, particles, particles.velocity, request, of_drag);
    particles.force += others_;
    kick(particles, 0.5 * settings.timestep);
    constrain_velocities(state, forces, settings);
    request.observe = observe;
    forces.compute(state.box, particles, particles.velocity, request, of_drag);
    particles.force += others_;
    totals.drag = of_drag.drag;
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
