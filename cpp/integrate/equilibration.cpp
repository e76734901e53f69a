// Equilibration (see equilibration.hpp).
#include "integrate/equilibration.hpp"

#include <cmath>

#include "constraints/constraints.hpp"
#include "core/random.hpp"
#include "observe/kinetic.hpp"

namespace dlpoly {

void draw_velocities(State& state, const StepSettings& settings, Stream stream, bool zero_momentum,
                     Constraints* constraints) {
    Particles& particles = state.particles;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        const double inverse_mass = particles.inverse_mass(i);
        const double width = std::sqrt(settings.thermal_energy * inverse_mass);
        const auto id = static_cast<std::uint32_t>(i);
        const auto xy = gaussian_pair(draw(settings.seed, stream, state.step, id, 0));
        const double z = gaussian(draw(settings.seed, stream, state.step, id, 1));
        particles.velocity.row(i) = width * Vector3(xy[0], xy[1], z).transpose();
        particles.velocity(i, 0) += settings.shear_rate * particles.position(i, 1);
    }
    if (zero_momentum) {
        remove_drift(particles, settings.shear_rate);
    }
    if (constraints != nullptr) {
        constraints->after_kick(state.box, particles, settings.timestep, state.step);
    }
    rescale_velocities(particles, settings);
}

void rescale_velocities(Particles& particles, const StepSettings& settings) {
    const double present = kinetic_tensor(particles, settings.shear_rate).trace();
    const double wanted = static_cast<double>(settings.degrees_of_freedom) * settings.thermal_energy;
    if (present > 0.0 && settings.degrees_of_freedom > 0) {
        const double factor = std::sqrt(wanted / present);
        particles.velocity *= factor;
        if (settings.shear_rate != 0.0) {
            particles.velocity.col(0) += (1.0 - factor) * settings.shear_rate * particles.position.col(1);
        }
    }
}

void cap_forces(Particles& particles, double largest) {
    Vector3 total = Vector3::Zero();
    Eigen::Index mobile = 0;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] != 0) {
            continue;
        }
        const double size = particles.force.row(i).norm();
        if (size > largest) {
            particles.force.row(i) *= largest / size;
        }
        total += particles.force.row(i).transpose();
        ++mobile;
    }
    if (mobile == 0) {
        return;
    }
    const Vector3 mean = total / static_cast<double>(mobile);
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
            particles.force.row(i) -= mean.transpose();
        }
    }
}

void equilibrate(State& state, const StepSettings& settings, Constraints* constraints) {
    if (state.step > settings.equilibration_steps) {
        return;
    }
    if (settings.regauss_every > 0 && state.step % settings.regauss_every == 0) {
        draw_velocities(state, settings, Stream::regauss, true, constraints);
    }
    if (settings.rescale_every > 0 && state.step % settings.rescale_every == 0) {
        rescale_velocities(state.particles, settings);
    }
}

}  // namespace dlpoly
