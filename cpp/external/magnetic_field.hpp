// A uniform magnetic field, DL_POLY's `magn`: F = q v × H. Between kicks a bead flies along its helix, which is
// followed exactly: the field does no work for any timestep, and a bead without other forces turns at q H/m.
#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "external/flight.hpp"

namespace dlpoly {

class MagneticField final : public Flight {
  public:
    // field: Hx Hy Hz, Da/(e ps); charges: one a bead, e.
    MagneticField(const Vector3& field, std::vector<double> charges) : charges_(std::move(charges)) {
        strength_ = field.norm();
        direction_ = strength_ > 0.0 ? Vector3(field / strength_) : Vector3::UnitZ();
    }

    [[nodiscard]] Vector3 move(Particles& particles, Eigen::Index bead, double time) const override {
        const Vector3 velocity = particles.velocity.row(bead).transpose();
        const Vector3 position = particles.position.row(bead).transpose();
        const double rate = -charges_[static_cast<std::size_t>(bead)] * particles.inverse_mass(bead) * strength_;
        const double angle = rate * time;
        if (angle == 0.0) {
            return position + time * velocity;
        }
        const Vector3 along = direction_.dot(velocity) * direction_;
        const Vector3 across = velocity - along;
        const Vector3 turned = direction_.cross(across);
        const double half = std::sin(0.5 * angle);
        particles.velocity.row(bead) = (along + std::cos(angle) * across + std::sin(angle) * turned).transpose();
        return position + time * along + (std::sin(angle) * across + 2.0 * half * half * turned) / rate;
    }

  private:
    Vector3 direction_;
    double strength_ = 0.0;
    std::vector<double> charges_;
};

}  // namespace dlpoly
