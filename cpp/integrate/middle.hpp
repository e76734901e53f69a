// The simultaneous middle step: half a kick, half a drift, drag and noise of all pairs at once, half a drift, new
// conservative forces, half a kick. The step in the middle is a fixed-point iteration towards the implicit midpoint
// rule v' = v − ½hA(v + v') + Sζ, which leaves the Maxwell distribution as it is for every h; A is the drag operator of
// the configuration between the half-drifts, S its noise. Two passes over the pairs (Heun) leave an error of ½(hA)³ in
// the covariance. No order of pairs enters: any number of threads gives the same bits, and momentum is exact.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class Middle final : public Integrator {
  public:
    void start(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  private:
    void thermalise(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals);

    Array3N before_;  // velocities before drag and noise
    Array3N mean_;    // of the velocities before and after
};

}  // namespace dlpoly
