// Berendsen's thermostat (see berendsen.hpp).
#include "integrate/berendsen.hpp"

#include <algorithm>
#include <cmath>

#include "integrate/moves.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void Berendsen::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    Particles& particles = state.particles;
    kick(particles, 0.5 * settings.timestep);
    constrain_drift(state, forces, settings.timestep);
    drift(state, settings, settings.timestep);
    advance_clock(state, settings);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    kick(particles, 0.5 * settings.timestep);
    constrain_velocities(state, forces, settings);
    const double present = kinetic_tensor(particles).trace();
    if (present > 0.0) {
        const double wanted = static_cast<double>(settings.degrees_of_freedom) * thermal_energy_now(state, settings);
        const double change = settings.timestep / settings.relaxation * (wanted / present - 1.0);
        particles.velocity *= std::sqrt(std::max(0.0, 1.0 + change));
    }
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
