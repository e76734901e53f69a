// The integrators by name (see integrator.hpp).
#include "integrate/integrator.hpp"

#include <stdexcept>

#include "integrate/berendsen.hpp"
#include "integrate/drag_recomputed.hpp"
#include "integrate/langevin.hpp"
#include "integrate/middle.hpp"
#include "integrate/moves.hpp"
#include "integrate/nose_hoover.hpp"
#include "integrate/nose_hoover_langevin.hpp"
#include "integrate/piston.hpp"
#include "integrate/self_consistent.hpp"
#include "integrate/splitting.hpp"
#include "integrate/velocity_verlet.hpp"

namespace dlpoly {

void Integrator::start(State& state, Forces& forces, const StepSettings& settings, bool observe,
                       PairTotals& totals) const {
    if (variables() > 0) {
        state.thermostat.resize(variables(), 0.0);
    }
    start_piston(state, settings);
    const ForceRequest request =
        drag_is_a_force() ? request_of(state, settings, observe) : conservative_request(state, settings, observe);
    compute_forces(state, forces, settings, request, state.particles.velocity, totals);
}

std::unique_ptr<Integrator> make_integrator(const StepSettings& settings) {
    switch (settings.order) {
        case Order::velocity_verlet:
            return std::make_unique<VelocityVerlet>();
        case Order::dpdvv:
            return std::make_unique<DragRecomputed>();
        case Order::scvv:
            return std::make_unique<SelfConsistent>();
        case Order::middle:
            return std::make_unique<Middle>();
        case Order::nose_hoover_langevin:
            return std::make_unique<NoseHooverLangevin>();
        case Order::langevin:
            return std::make_unique<Langevin>();
        case Order::berendsen:
            return std::make_unique<Berendsen>();
        case Order::hoover:
            return std::make_unique<NoseHoover>();
        case Order::zeroth:
        case Order::first:
        case Order::second:
        case Order::peters:
        case Order::peters_first:
        case Order::lowe_andersen:
        case Order::stoyanov_groot:
        case Order::ou:
        case Order::ou_middle:
            return std::make_unique<Splitting>(settings.order);
    }
    throw std::invalid_argument("no such integrator");
}

}  // namespace dlpoly
