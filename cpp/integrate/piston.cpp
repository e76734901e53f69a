// The Langevin piston (see piston.hpp).
#include "integrate/piston.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "core/random.hpp"
#include "integrate/moves.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

// Edges x, y, z: the number of the rate that each has, −1 for an edge that stays as it is.
std::array<int, 3> rates_of(CellMotion motion) {
    switch (motion) {
        case CellMotion::isotropic:
            return {0, 0, 0};
        case CellMotion::height:
            return {-1, -1, 0};
        case CellMotion::square:
            return {0, 0, 1};
        case CellMotion::edges:
            return {0, 1, 2};
        case CellMotion::fixed:
            break;
    }
    return {-1, -1, -1};
}

// Inertia of one edge.
double edge_mass(const StepSettings& settings) {
    return static_cast<double>(settings.degrees_of_freedom) * settings.thermal_energy * settings.barostat.relaxation *
           settings.barostat.relaxation / 3.0;
}

bool takes_velocities_in_middle(const StepSettings& settings) {
    return settings.order == Order::middle || settings.order == Order::ou_middle || settings.order == Order::langevin ||
           (settings.order == Order::velocity_verlet && settings.half_step_kinetic);
}

// Changes the rates by what acts on the edges, each rate by the sum over its edges.
void accelerate(State& state, const StepSettings& settings, const Vector3& force, double time) {
    const std::array<int, 3> rates = rates_of(settings.barostat.motion);
    const double mass = edge_mass(settings);
    for (int rate = 0; rate < 3; ++rate) {
        double sum = 0.0;
        double inertia = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sum += rates[axis] == rate ? force[static_cast<Eigen::Index>(axis)] : 0.0;
            inertia += rates[axis] == rate ? mass : 0.0;
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (rates[axis] == rate) {
                state.thermostat[axis] += time * sum / inertia;
            }
        }
    }
}

Vector3 force_of_velocities(const State& state, const StepSettings& settings) {
    const Matrix3 kinetic = kinetic_tensor(state.particles);
    return kinetic.diagonal().array() + kinetic.trace() / static_cast<double>(settings.degrees_of_freedom);
}

}  // namespace

void start_piston(State& state, const StepSettings& settings) {
    if (settings.barostat.acts()) {
        state.thermostat.resize(3, 0.0);
    }
}

void push_piston(State& state, const Forces& forces, const PairTotals& totals, const StepSettings& settings,
                 double time) {
    const Barostat& barostat = settings.barostat;
    if (!barostat.acts()) {
        return;
    }
    const double volume = state.box.volume();
    Vector3 force = totals.conservative.diagonal();
    for (std::size_t kind = 0; kind < bonded::kinds; ++kind) {
        force += forces.bonded_totals().virial[kind].diagonal();
    }
    force += forces.charge_totals().virial.diagonal();
    force.array() -= barostat.tail / (3.0 * volume);
    const double pull = barostat.tension * volume / state.box.cell()(2, 2);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        force[axis] -= volume * barostat.pressure[static_cast<std::size_t>(axis)] - (axis < 2 ? pull : 0.0);
    }
    if (!takes_velocities_in_middle(settings)) {
        force += force_of_velocities(state, settings);
    }
    accelerate(state, settings, force, time);
}

void enter_middle(State& state, const StepSettings& settings) {
    if (settings.barostat.acts() && takes_velocities_in_middle(settings)) {
        accelerate(state, settings, force_of_velocities(state, settings), 0.5 * settings.timestep);
    }
}

void leave_middle(State& state, const StepSettings& settings) {
    const Barostat& barostat = settings.barostat;
    if (!barostat.acts()) {
        return;
    }
    const std::array<int, 3> rates = rates_of(barostat.motion);
    const double keep = std::exp(-barostat.friction * settings.timestep);
    const double energy =
        thermal_energy_now(state, settings) * -std::expm1(-2.0 * barostat.friction * settings.timestep);
    for (int rate = 0; rate < 3; ++rate) {
        double inertia = 0.0;
        for (const int of_edge : rates) {
            inertia += of_edge == rate ? edge_mass(settings) : 0.0;
        }
        if (inertia == 0.0) {
            continue;
        }
        const auto number = static_cast<std::uint32_t>(rate);
        const double noise =
            std::sqrt(energy / inertia) * gaussian(draw(settings.seed, Stream::barostat, state.step, number, 0));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (rates[axis] == rate) {
                state.thermostat[axis] = keep * state.thermostat[axis] + noise;
            }
        }
    }
    enter_middle(state, settings);  // the second half of what the velocities do
}

double barostat_energy(const State& state, const StepSettings& settings) {
    const Barostat& barostat = settings.barostat;
    if (!barostat.acts() || state.thermostat.size() < 3) {
        return 0.0;
    }
    const std::array<int, 3> rates = rates_of(barostat.motion);
    double energy = 0.0;
    double pressure = 0.0;
    int moving = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (rates[axis] >= 0) {
            energy += 0.5 * edge_mass(settings) * state.thermostat[axis] * state.thermostat[axis];
            pressure += barostat.pressure[axis];
            ++moving;
        }
    }
    const double volume = state.box.volume();
    return energy + pressure / moving * volume - barostat.tension * volume / state.box.cell()(2, 2);
}

}  // namespace dlpoly
