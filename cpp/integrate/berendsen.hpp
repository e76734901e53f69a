// Berendsen's thermostat, J. Chem. Phys. 81, 3684 (1984): after each step of velocity Verlet all velocities are scaled
// by √(1 + Δt/τ (T₀/T − 1)). It reaches the temperature without the fluctuations of the canonical ensemble.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class Berendsen final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;
};

}  // namespace dlpoly
