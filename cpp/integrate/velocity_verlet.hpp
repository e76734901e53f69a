// Velocity Verlet and, with drag and noise, the modified velocity Verlet of Groot and Warren, J. Chem. Phys. 107, 4423
// (1997): r += Δt v + ½Δt² f; ṽ = v + λΔt f; v += ½Δt f; f = f(r, ṽ); v += ½Δt f. With λ = ½ the predicted velocity is
// the half-step velocity, which is what DL_POLY calls mdvv.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class VelocityVerlet final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  protected:
    [[nodiscard]] bool drag_is_a_force() const override { return true; }

  private:
    Array3N predicted_;
};

}  // namespace dlpoly
