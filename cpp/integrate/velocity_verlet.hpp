// Velocity Verlet and, with drag and noise, the modified velocity Verlet of Groot and Warren, J. Chem. Phys. 107, 4423
// (1997): r += Δt v + ½Δt² f; ṽ = v + λΔt f; v += ½Δt f; f = f(r, ṽ); v += ½Δt f. With λ = ½ the predicted velocity is
// the half-step velocity, which is what DL_POLY calls mdvv.
#pragma once

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

class VelocityVerlet {
  public:
    // Forces for the present positions and velocities, before the first step.
    void start(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals);

    // One step. Throws RunFailure naming the bead when a position stops being finite.
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals);

  private:
    void evaluate(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity, bool observe,
                  PairTotals& totals);

    Array3N predicted_;
};

}  // namespace dlpoly
