// The moves that integrators are made of (see moves.hpp).
#include "integrate/moves.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "core/failure.hpp"
#include "integrate/equilibration.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void kick(Particles& particles, double time) {
    const Eigen::Index beads = particles.count();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        particles.velocity.row(i) += time * particles.inverse_mass(i) * particles.force.row(i);
    }
}

void drift(State& state, const StepSettings& settings, double time) {
    Particles& particles = state.particles;
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
    std::atomic<Eigen::Index> lost{-1};
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (Eigen::Index i = 0; i < beads; ++i) {
        Vector3 position = (particles.position.row(i) + time * particles.velocity.row(i)).transpose();
        if (!state.box.wrap(position, particles.image.row(i).data())) {
            lost = i;
        } else {
            particles.position.row(i) = position.transpose();
        }
    }
    if (lost >= 0) {
        throw RunFailure("step " + std::to_string(state.step + 1) + ": bead " + std::to_string(lost + 1) +
                         " left all bounds or its position is not a number; the timestep is too long for the forces");
    }
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
    request.observe = observe;
    request.gaussian_noise = settings.precision == Precision::reference;
    request.seed = settings.seed;
    request.step = state.step;
    return request;
}

void compute_forces(State& state, Forces& forces, const StepSettings& settings, const ForceRequest& request,
                    const Array3N& velocity, PairTotals& totals) {
    forces.compute(state.box, state.particles, velocity, request, totals);
    if (settings.force_cap > 0.0 && state.step <= settings.equilibration_steps) {
        cap_forces(state.particles, settings.force_cap);
    }
}

void advance_clock(State& state, const StepSettings& settings) {
    ++state.step;
    state.time += settings.timestep;
}

void finish_step(State& state, const StepSettings& settings) {
    if (settings.remove_drift) {
        remove_drift(state.particles);
    }
    equilibrate(state, settings);
}

}  // namespace dlpoly
