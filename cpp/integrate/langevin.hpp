// Langevin dynamics of single beads: velocity Verlet with friction and noise in the middle of the drift, the exact
// v' = c v + √(k_B T/m (1 − c²)) ζ with c = exp(−χΔt) (the order of moves BAOAB of Leimkuhler and Matthews, Appl. Math.
// Res. Express 2013, 34). It damps flow: momentum is not conserved.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class Langevin final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;
};

}  // namespace dlpoly
