// One simulation (see system.hpp).
#include "integrate/system.hpp"

#include <utility>

namespace dlpoly {

System::System(State initial, Forces all_forces, StepSettings step_settings)
    : state(std::move(initial)), forces(std::move(all_forces)), settings(step_settings) {}

void System::initialise() {
    integrator_.start(state, forces, settings, true, totals);
    ready = true;
}

void System::run(std::uint64_t steps) {
    if (!ready) {
        initialise();
    }
    for (std::uint64_t k = 0; k < steps; ++k) {
        integrator_.step(state, forces, settings, k + 1 == steps, totals);
        if (distances && distances_every > 0 && state.step > distances_after && state.step % distances_every == 0) {
            distances->sample(state.box, state.particles);
        }
    }
}

PairTotals System::conservative_totals() {
    Particles copy = state.particles;
    PairTotals result;
    ForceRequest request;
    request.observe = true;
    request.step = state.step;
    forces.compute(state.box, copy, copy.velocity, request, result);
    return result;
}

void System::enable_distances(double range, std::int32_t bins, std::uint64_t every, std::uint64_t after) {
    distances.emplace(forces.pairs().table().species(), range, bins);
    distances_every = every;
    distances_after = after;
}

}  // namespace dlpoly
