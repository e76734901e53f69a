// Velocity Verlet with a sweep over the pairs before it, after it, on both sides or in the middle of its drift: the
// splitting thermostats. The map that a pair undergoes and the place of the sweep make the scheme:
//
//   zeroth          implicit step, before           first, second  Shardlow's map, before / half before and half after
//   peters          exact map, after                peters_first   Peters' scheme I, after
//   lowe_andersen   chosen pairs anew, after        stoyanov_groot the same and a drag of the others, after
//   ou, ou_middle   exact map, before / in the middle of the drift
#pragma once

#include <optional>

#include "integrate/integrator.hpp"
#include "sweep/pair_sweep.hpp"

namespace dlpoly {

class Splitting final : public Integrator {
  public:
    explicit Splitting(Order order) : order_(order) {}

    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  private:
    void sweep(State& state, Forces& forces, const StepSettings& settings, double duration, Stream stream,
               bool backward, bool observe);

    Order order_;
    std::optional<PairSweep> sweep_;
    Matrix3 virial_ = Matrix3::Zero();  // of the step's sweeps
};

// What a sweep of the present step is told.
SweepSettings sweep_settings(const State& state, const StepSettings& settings, double duration, Stream stream);

}  // namespace dlpoly
