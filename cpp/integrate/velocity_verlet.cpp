// Velocity Verlet (see velocity_verlet.hpp).
#include "integrate/velocity_verlet.hpp"

#include "integrate/moves.hpp"
#include "integrate/piston.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void VelocityVerlet::step(State& state, Forces& forces, const StepSettings& settings, bool observe,
                          PairTotals& totals) {
    Particles& particles = state.particles;
    const double timestep = settings.timestep;
    push_piston(state, forces, totals, settings, 0.5 * timestep);
    const bool predict = settings.drag && settings.prediction != 0.5;
    if (predict) {
        predicted_ = particles.velocity;
        const Eigen::Index beads = particles.count();
        for (Eigen::Index i = 0; i < beads; ++i) {
            predicted_.row(i) += settings.prediction * timestep * particles.inverse_mass(i) * particles.force.row(i);
        }
    }
    const bool constrained = forces.constraints() != nullptr;
    if (predict && constrained) {
        predicted_ = particles.velocity;
    }
    kick(state, settings, 0.5 * timestep);
    constrain_drift(state, forces, timestep);
    if (predict && constrained) {  // the forces of constraints change the prediction, too
        predicted_ += 2.0 * settings.prediction * (particles.velocity - predicted_);
    }
    std::optional<Matrix3> kinetic;
    if (observe && settings.half_step_kinetic) {
        kinetic = kinetic_tensor(particles);
    }
    drift_through(state, settings);
    advance_clock(state, settings);
    compute_forces(state, forces, settings, request_of(state, settings, observe),
                   predict ? predicted_ : particles.velocity, totals);
    totals.kinetic = kinetic;
    kick(state, settings, 0.5 * timestep);
    constrain_velocities(state, forces, settings);
    push_piston(state, forces, totals, settings, 0.5 * timestep);
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
