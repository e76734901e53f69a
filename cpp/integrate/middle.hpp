// The simultaneous middle step: half a kick, half a drift, drag and noise of all pairs at once, half a drift, new
// conservative forces, half a kick.
//
// With A the drag operator of the configuration between the half-drifts, s its noise over the time h and v the velocity
// there, the passes over the pairs are
//   2:  v' = v + s − hA(v + ¼s)
//   3:  v' = v + s − hA(v + ½s − ½hA(v + ¼s))
// and 1 is the explicit step v' = v + s − hAv. A mode that relaxes by x = hA keeps its temperature up to x²/16 with two
// passes and x⁴/64 with three, and not better than x/2 with one. (With the same two evaluations, Heun's rule errs by
// x³/2 in the covariance.) No order of pairs enters: any number of threads gives the same bits, and momentum is exact.
// With thermostat_every = m, the middle of every m-th step takes the drag and noise of m steps at once.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

class Middle final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  private:
    void thermalise(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals);

    Array3N before_;    // velocities before drag and noise
    Array3N noise_;     // what the noise changes them by
    Array3N estimate_;  // velocities that the drag is computed from
};

}  // namespace dlpoly
