// DPD-VV: velocity Verlet whose drag is computed once more from the velocities of the whole step, for the next step's
// first half (Gibson, Chen and Chynoweth, Int. J. Mod. Phys. C 10, 241 (1999); Besold et al., Phys. Rev. E 62, R7611
// (2000); GALAMOST's DPDVV, DL_MESO's dpdvv).
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class DragRecomputed final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  protected:
    [[nodiscard]] bool drag_is_a_force() const override { return true; }

  private:
    Array3N others_;  // conservative forces and noise
};

}  // namespace dlpoly
