// SC-VV: velocity Verlet whose second half-kick is repeated until drag and velocities belong together,
// v = v_half + ½Δt (F^C + F^R + F^D(v))/m (Pagonabarraga, Hagen and Frenkel, Europhys. Lett. 42, 377 (1998); Besold et
// al., Phys. Rev. E 62, R7611 (2000)).
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class SelfConsistent final : public Integrator {
  public:
    // Throws RunFailure when the iteration does not converge: the timestep is too long for the drag.
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  protected:
    [[nodiscard]] bool drag_is_a_force() const override { return true; }

  private:
    Array3N others_;   // conservative forces and noise
    Array3N halfway_;  // velocities after the first half-kick
};

}  // namespace dlpoly
