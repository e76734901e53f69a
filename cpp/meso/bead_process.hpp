// Something that happens to what beads carry, heat or dissolved species, once a step and with positions standing still:
// exchange between neighbours, sources, reactions. One process = one class in this folder.
#pragma once

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

class BeadProcess {
  public:
    BeadProcess() = default;
    BeadProcess(const BeadProcess&) = delete;
    BeadProcess& operator=(const BeadProcess&) = delete;
    BeadProcess(BeadProcess&&) = delete;
    BeadProcess& operator=(BeadProcess&&) = delete;
    virtual ~BeadProcess() = default;

    // After the forces of a start were computed, from which no step was taken yet.
    virtual void start(State& /*state*/, Forces& /*forces*/, const StepSettings& /*settings*/) {}

    // Takes what beads carry over one timestep. Called after the integrator's step: positions, velocities and forces
    // are those of its end, and state.step counts it. Throws RunFailure naming the bead when a number stops being
    // finite.
    virtual void advance(State& state, Forces& forces, const StepSettings& settings) = 0;
};

}  // namespace dlpoly
