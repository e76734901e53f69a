// The moves that integrators are made of.
#pragma once

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

// v += time · F/m.
void kick(Particles& particles, double time);

// The same while the cell's edges move: exact for the present forces and rates (see piston.hpp).
void kick(State& state, const StepSettings& settings, double time);

// r += time · v, or as settings.flight has it, wrapped into the cell; a cell that moves is scaled with the positions,
// one that is sheared tilts (see shear.hpp). Throws RunFailure naming a bead whose position is not finite or that would
// move farther than settings.longest_move, or where the cell would change by more than a quarter; the state is then
// that before the drift.
void drift(State& state, const StepSettings& settings, double time);

// The whole drift of a step, with what a piston does in its middle.
void drift_through(State& state, const StepSettings& settings);

// Velocities that a drift by `time` takes to the right lengths, and velocities that change no length. Both do nothing
// where the scene has no constraints.
void constrain_drift(State& state, Forces& forces, double time);
void constrain_velocities(State& state, Forces& forces, const StepSettings& settings);

// Around what a thermostat does to the velocities of pairs: with constraints, velocities that change no length become
// those of free beads, and go back. `part` counts the thermostat's parts in one step.
void enter_thermostat(State& state, Forces& forces, const StepSettings& settings, std::uint32_t part = 0);
void leave_thermostat(State& state, Forces& forces, const StepSettings& settings);

// What a force evaluation of the present step is asked for; drag and noise as the settings have them.
ForceRequest request_of(const State& state, const StepSettings& settings, bool observe);

// The same without drag and noise. A piston needs every step observed.
ForceRequest conservative_request(const State& state, const StepSettings& settings, bool observe);

// Computes forces; caps them while the settings say so.
void compute_forces(State& state, Forces& forces, const StepSettings& settings, const ForceRequest& request,
                    const Array3N& velocity, PairTotals& totals);

// Counts the step.
void advance_clock(State& state, const StepSettings& settings);

// What is done to velocities once a step is complete: removal of drift, rescaling, redrawing.
void finish_step(State& state, const StepSettings& settings, Constraints* constraints = nullptr);

// k_B T at the present time.
double thermal_energy_now(const State& state, const StepSettings& settings);

}  // namespace dlpoly
