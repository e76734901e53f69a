// Measures that act only while a run equilibrates, and the Maxwell velocities of its start. In a sheared cell
// velocities are those relative to the flow, and the flow stays.
#pragma once

#include "core/state.hpp"
#include "core/streams.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

class Constraints;

// Draws velocities of every mobile bead from the Maxwell distribution at settings.thermal_energy, takes out the drift
// if asked and what constraints forbid, and scales them to exactly that temperature. A pure function of seed, stream,
// step and bead id, and of the positions where there are constraints.
void draw_velocities(State& state, const StepSettings& settings, Stream stream, bool zero_momentum,
                     Constraints* constraints = nullptr);

// Scales all velocities so that the kinetic energy is ½ · degrees of freedom · k_B T. Does nothing at rest.
void rescale_velocities(Particles& particles, const StepSettings& settings);

// Shortens every force longer than `largest` to it, then takes the mean force from all mobile beads so that the total
// momentum stays.
void cap_forces(Particles& particles, double largest);

// Rescaling and redrawing when this step is due for them.
void equilibrate(State& state, const StepSettings& settings, Constraints* constraints = nullptr);

}  // namespace dlpoly
