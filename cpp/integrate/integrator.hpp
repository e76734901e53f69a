// What every integrator provides; one integrator or thermostat = one file in this folder and one line in
// make_integrator.
#pragma once

#include <cstddef>
#include <memory>

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

class Integrator {
  public:
    Integrator() = default;
    Integrator(const Integrator&) = delete;
    Integrator& operator=(const Integrator&) = delete;
    Integrator(Integrator&&) = delete;
    Integrator& operator=(Integrator&&) = delete;
    virtual ~Integrator() = default;

    // Forces for the present positions and velocities, before the first step, and room for the variables.
    void start(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) const;

    // One step; energies and stress only when asked to observe. Throws RunFailure naming the bead when a position or a
    // force stops being finite.
    virtual void step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) = 0;

  protected:
    // Whether drag and noise of pairs are forces; else the integrator brings them in by itself.
    [[nodiscard]] virtual bool drag_is_a_force() const { return false; }
    // How many numbers it keeps in State::thermostat.
    [[nodiscard]] virtual std::size_t variables() const { return 0; }
};

std::unique_ptr<Integrator> make_integrator(const StepSettings& settings);

}  // namespace dlpoly
