// Kinetic quantities (see kinetic.hpp). Sums run over bead ids in one order, so their bits do not depend on threads.
#include "observe/kinetic.hpp"

namespace dlpoly {

namespace {

Vector3 relative_velocity(const Particles& particles, Eigen::Index bead, double shear_rate) {
    Vector3 velocity = particles.velocity.row(bead).transpose();
    velocity[0] -= shear_rate * particles.position(bead, 1);
    return velocity;
}

}  // namespace

Matrix3 kinetic_tensor(const Particles& particles, double shear_rate) {
    Matrix3 tensor = Matrix3::Zero();
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
            const Vector3 v = relative_velocity(particles, i, shear_rate);
            tensor += particles.mass[static_cast<std::size_t>(i)] * v * v.transpose();
        }
    }
    return tensor;
}

Vector3 momentum(const Particles& particles, double shear_rate) {
    Vector3 total = Vector3::Zero();
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
            total += particles.mass[static_cast<std::size_t>(i)] * relative_velocity(particles, i, shear_rate);
        }
    }
    return total;
}

double mobile_mass(const Particles& particles) {
    double total = 0.0;
    for (std::size_t i = 0; i < particles.mass.size(); ++i) {
        total += particles.frozen[i] == 0 ? particles.mass[i] : 0.0;
    }
    return total;
}

void remove_drift(Particles& particles, double shear_rate) {
    const double mass = mobile_mass(particles);
    if (!(mass > 0.0)) {
        return;
    }
    const Vector3 drift = momentum(particles, shear_rate) / mass;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
            particles.velocity.row(i) -= drift.transpose();
        }
    }
}

}  // namespace dlpoly
