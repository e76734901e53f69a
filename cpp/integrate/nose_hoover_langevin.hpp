// The pairwise Nosé–Hoover–Langevin thermostat (Leimkuhler and Shang, arXiv:1405.4839 (2015)): a drag ζ w^D(r) that all
// pairs share follows dζ = [Σ w^D (u² − k_B T/μ)/M − γ_ζ ζ] dt + √(2 k_B T γ_ζ/M) dW. After each step of velocity
// Verlet: half a sweep with ζ, ζ over the whole step (half its friction and noise, its force, the other half), half a
// sweep back. M is settings.thermostat_mass in units of k_B T/γ², times the number of degrees of freedom; γ_ζ is
// settings.thermostat_friction.
#pragma once

#include <optional>

#include "integrate/integrator.hpp"
#include "sweep/pair_sweep.hpp"

namespace dlpoly {

class NoseHooverLangevin final : public Integrator {
  public:
    void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) override;

  protected:
    [[nodiscard]] std::size_t variables() const override { return 1; }

  private:
    std::optional<PairSweep> sweep_;
};

}  // namespace dlpoly
