// The pairwise Nosé–Hoover–Langevin thermostat (see nose_hoover_langevin.hpp).
#include "integrate/nose_hoover_langevin.hpp"

#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "integrate/moves.hpp"
#include "integrate/splitting.hpp"
#include "sweep/common_drag.hpp"

namespace dlpoly {

void NoseHooverLangevin::step(State& state, Forces& forces, const StepSettings& settings, bool observe,
                              PairTotals& totals) {
    if (!sweep_) {
        sweep_.emplace(forces.pairs().table(), forces.pairs().exclusions());
    }
    Particles& particles = state.particles;
    const double timestep = settings.timestep;
    kick(particles, 0.5 * timestep);
    drift(state, settings, timestep);
    advance_clock(state, settings);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    kick(particles, 0.5 * timestep);

    double& drag = state.thermostat[0];
    double largest = 0.0;
    for (const PairDrag& pair : forces.pairs().table().drags()) {
        largest = std::max(largest, pair.drag);
    }
    const double thermal_energy = thermal_energy_now(state, settings);
    SweepSettings told = sweep_settings(state, settings, 0.5 * timestep, Stream::sweep_words);
    told.observe = observe;
    sweep_->apply(state.box, particles, sweep::CommonDrag{drag}, told);
    Matrix3 virial = 0.5 * sweep_->virial();
    const double mass = settings.thermostat_mass * thermal_energy / (largest * largest) *
                        static_cast<double>(std::max<std::int64_t>(settings.degrees_of_freedom, 1));
    if (mass > 0.0) {
        const double keep = std::exp(-0.5 * timestep * settings.thermostat_friction);
        const double width = std::sqrt(thermal_energy / mass * (1.0 - keep * keep));
        const auto noise = gaussian_pair(draw(settings.seed, Stream::thermostat, state.step, 0, 0));
        drag = keep * drag + width * noise[0];
        drag += timestep * sweep_->measure(state.box, particles, told).excess / mass;
        drag = keep * drag + width * noise[1];
    }
    told.backward = true;
    sweep_->apply(state.box, particles, sweep::CommonDrag{drag}, told);
    virial += 0.5 * sweep_->virial();
    totals.drag = virial;
    finish_step(state, settings);
}

}  // namespace dlpoly
