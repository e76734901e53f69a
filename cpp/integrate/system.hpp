// One simulation: state, forces, integrator, and what was observed in the last step that was asked to observe.
#pragma once

#include <optional>

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"
#include "integrate/velocity_verlet.hpp"
#include "observe/pair_distances.hpp"

namespace dlpoly {

class System {
  public:
    System(State state, Forces forces, StepSettings settings);

    // Forces at the present positions and velocities, observed; `drag` as the settings have it.
    void initialise();

    // Takes `steps` steps and observes the last one. Samples pair distances in steps divisible by distances_every,
    // later than distances_after.
    void run(std::uint64_t steps);

    // Energies and stress of the conservative forces at the present positions, without touching the stored forces.
    PairTotals conservative_totals();

    void enable_distances(double range, std::int32_t bins, std::uint64_t every, std::uint64_t after);

    State state;
    Forces forces;
    StepSettings settings;
    PairTotals totals;
    std::optional<PairDistances> distances;
    std::uint64_t distances_every = 0;
    std::uint64_t distances_after = 0;
    bool ready = false;  // forces belong to the present positions

  private:
    VelocityVerlet integrator_;
};

}  // namespace dlpoly
