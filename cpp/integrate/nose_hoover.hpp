// The Nosé–Hoover thermostat (Hoover, Phys. Rev. A 31, 1695 (1985)) with the moves of Martyna, Tuckerman, Tobias and
// Klein, Mol. Phys. 87, 1117 (1996): friction χ with dχ/dt = (2K − g k_B T)/Q and Q = g k_B T τ², half a step of it
// before and after velocity Verlet. K + U + ½Qχ² + g k_B T ∫χ dt is conserved where the temperature is constant.
#pragma once

#include "integrate/integrator.hpp"

namespace dlpoly {

// State::thermostat holds χ and ∫χ dt.
class NoseHoover final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  protected:
    [[nodiscard]] std::size_t variables() const override { return 2; }
};

// ½Qχ² + g k_B T ∫χ dt; 0 for other integrators.
double thermostat_energy(const State& state, const StepSettings& settings);

}  // namespace dlpoly
