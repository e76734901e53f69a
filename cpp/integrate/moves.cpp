// The moves that integrators are made of (see moves.hpp).
#include "integrate/moves.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/failure.hpp"
#include "external/flight.hpp"
#include "integrate/equilibration.hpp"
#include "integrate/piston.hpp"
#include "integrate/shear.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

// (eˣ − 1)/x.
double mean_growth(double x) { return std::abs(x) < 1e-8 ? 1.0 + 0.5 * x : std::expm1(x) / x; }

}  // namespace

void kick(Particles& particles, double time) {
    const Eigen::Index beads = particles.count();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        particles.velocity.row(i) += time * particles.inverse_mass(i) * particles.force.row(i);
    }
}

void kick(State& state, const StepSettings& settings, double time) {
    Particles& particles = state.particles;
    if (!settings.barostat.acts()) {
        kick(particles, time);
        return;
    }
    const std::vector<double>& rates = state.thermostat;
    const double common = (rates[0] + rates[1] + rates[2]) / static_cast<double>(settings.degrees_of_freedom);
    Vector3 keep;
    Vector3 reach;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double exponent = -(rates[static_cast<std::size_t>(axis)] + common) * time;
        keep[axis] = std::exp(exponent);
        reach[axis] = time * mean_growth(exponent);
    }
    const Eigen::Index beads = particles.count();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        const double inverse_mass = particles.inverse_mass(i);
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            particles.velocity(i, axis) =
                keep[axis] * particles.velocity(i, axis) + reach[axis] * inverse_mass * particles.force(i, axis);
        }
    }
}

namespace {

// Throws RunFailure when a bead would move farther than it may, or has no velocity that is a number.
void refuse_long_moves(const State& state, const StepSettings& settings, double time) {
    const Particles& particles = state.particles;
    const Eigen::Index beads = particles.count();
    const double longest =
        settings.longest_move > 0.0 ? settings.longest_move : std::numeric_limits<double>::infinity();
    const double most = longest * longest / (time * time);
    std::atomic<Eigen::Index> fast{-1};
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        if (!(particles.velocity.row(i).squaredNorm() <= most)) {
            Eigen::Index first = fast;
            while ((first < 0 || i < first) && !fast.compare_exchange_weak(first, i)) {
            }
        }
    }
    if (fast >= 0) {
        const double moves = particles.velocity.row(fast).norm() * time;
        std::ostringstream text;
        text.precision(4);
        text << "step " << state.step + 1 << ": bead " << fast + 1;
        if (std::isfinite(moves)) {
            text << " would move by " << moves << ", farther than the pair interactions reach (" << longest << ")";
        } else {
            text << " has a velocity that is not a number";
        }
        text << "; the timestep is too long for the forces or velocities";
        throw RunFailure(text.str());
    }
}

// Takes every bead to `place(bead)`, wrapped into the cell; then settle(bead, image before).
template <class Place, class Settle>
void move_beads(State& state, const Place& place, const Settle& settle) {
    Particles& particles = state.particles;
    const Eigen::Index beads = particles.count();
    std::atomic<Eigen::Index> lost{-1};
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        Vector3 position = place(i);
        const auto before = particles.image.row(i).eval();
        if (!state.box.wrap(position, particles.image.row(i).data())) {
            lost = i;
        } else {
            particles.position.row(i) = position.transpose();
            settle(i, before);
        }
    }
    if (lost >= 0) {
        throw RunFailure("step " + std::to_string(state.step + 1) + ": bead " + std::to_string(lost + 1) +
                         " left all bounds or its position is not a number; the timestep is too long for the forces");
    }
}

template <class Place>
void move_beads(State& state, const Place& place) {
    move_beads(state, place, [](Eigen::Index, const auto&) {});
}

// A drift in a sheared cell: beads that cross a face across y take over the velocity of the flow there.
void drift_sheared(State& state, const StepSettings& settings, double time) {
    tilt(state, settings.shear_rate, time);
    Particles& particles = state.particles;
    const double flow = settings.shear_rate * state.box.cell()(1, 1);
    move_beads(
        state,
        [&](Eigen::Index i) -> Vector3 {
            return (particles.position.row(i) + time * particles.velocity.row(i)).transpose();
        },
        [&](Eigen::Index i, const auto& before) {
            particles.velocity(i, 0) -= flow * (particles.image(i, 1) - before[1]);
        });
}

}  // namespace

void drift(State& state, const StepSettings& settings, double time) {
    Particles& particles = state.particles;
    if (!settings.barostat.acts()) {
        refuse_long_moves(state, settings, time);
        if (settings.shear_rate != 0.0) {
            drift_sheared(state, settings, time);
            return;
        }
        if (settings.flight) {
            move_beads(state, [&](Eigen::Index i) { return settings.flight->move(particles, i, time); });
            return;
        }
        move_beads(state, [&](Eigen::Index i) -> Vector3 {
            return (particles.position.row(i) + time * particles.velocity.row(i)).transpose();
        });
        return;
    }
    Matrix3 cell = state.box.cell();
    Vector3 growth;
    Vector3 reach;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double exponent = state.thermostat[static_cast<std::size_t>(axis)] * time;
        if (!(std::abs(exponent) < 0.25)) {
            throw RunFailure("step " + std::to_string(state.step + 1) +
                             ": the cell would change by more than a quarter in one step; start nearer to the target "
                             "pressure, with a shorter timestep or a longer ensemble_barostat_coupling");
        }
        growth[axis] = std::exp(exponent);
        reach[axis] = time * mean_growth(exponent);
        cell.col(axis) *= growth[axis];
    }
    refuse_long_moves(state, settings, time);
    state.box = Box(cell, state.box.periodic());
    move_beads(state, [&](Eigen::Index i) -> Vector3 {
        return growth.cwiseProduct(particles.position.row(i).transpose()) +
               reach.cwiseProduct(particles.velocity.row(i).transpose());
    });
}

void drift_through(State& state, const StepSettings& settings) {
    if (!settings.barostat.acts()) {
        drift(state, settings, settings.timestep);
        return;
    }
    drift(state, settings, 0.5 * settings.timestep);
    enter_middle(state, settings);
    leave_middle(state, settings);
    drift(state, settings, 0.5 * settings.timestep);
}

void constrain_drift(State& state, Forces& forces, double time) {
    if (Constraints* constraints = forces.constraints()) {
        constraints->before_drift(state.box, state.particles, time, state.step + 1);
    }
}

void constrain_velocities(State& state, Forces& forces, const StepSettings& settings) {
    if (Constraints* constraints = forces.constraints()) {
        constraints->after_kick(state.box, state.particles, settings.timestep, state.step);
    }
}

void enter_thermostat(State& state, Forces& forces, const StepSettings& settings, std::uint32_t part) {
    if (Constraints* constraints = forces.constraints()) {
        constrain_velocities(state, forces, settings);
        const MaxwellDraw maxwell{thermal_energy_now(state, settings), settings.seed, state.step};
        constraints->release(state.box, state.particles, maxwell, part, settings.timestep);
    }
}

void leave_thermostat(State& state, Forces& forces, const StepSettings& settings) {
    constrain_velocities(state, forces, settings);
}

double thermal_energy_now(const State& state, const StepSettings& settings) {
    return std::max(0.0, settings.schedule.at(state.time, settings.thermal_energy));
}

ForceRequest request_of(const State& state, const StepSettings& settings, bool observe) {
    ForceRequest request = conservative_request(state, settings, observe);
    request.drag = settings.drag;
    request.noise = settings.drag;
    request.weight_exponent = settings.weight_exponent;
    request.inverse_root_timestep = settings.drag ? 1.0 / std::sqrt(settings.timestep) : 0.0;
    if (settings.schedule.varies() && settings.thermal_energy > 0.0) {
        request.noise_factor = std::sqrt(thermal_energy_now(state, settings) / settings.thermal_energy);
    }
    return request;
}

ForceRequest conservative_request(const State& state, const StepSettings& settings, bool observe) {
    ForceRequest request;
    request.observe = observe || settings.barostat.acts();
    request.always_observed = settings.barostat.acts();
    request.gaussian_noise = settings.precision == Precision::reference;
    request.seed = settings.seed;
    request.step = state.step;
    request.time = state.time;
    request.shear_rate = settings.shear_rate;
    return request;
}

void compute_forces(State& state, Forces& forces, const StepSettings& settings, const ForceRequest& request,
                    const Array3N& velocity, PairTotals& totals) {
    forces.compute(state.box, state.particles, velocity, request, totals);
    forces.steer(state.particles);
    if (settings.force_cap > 0.0 && state.step <= settings.equilibration_steps) {
        cap_forces(state.particles, settings.force_cap);
    }
}

void advance_clock(State& state, const StepSettings& settings) {
    ++state.step;
    state.time += settings.timestep;
}

void finish_step(State& state, const StepSettings& settings, Constraints* constraints) {
    if (settings.remove_drift) {
        remove_drift(state.particles, settings.shear_rate);
        if (constraints != nullptr) {  // beads that are held by a frozen one have lost their directions
            constraints->after_kick(state.box, state.particles, settings.timestep, state.step);
        }
    }
    equilibrate(state, settings, constraints);
}

}  // namespace dlpoly
