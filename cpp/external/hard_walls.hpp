// Hard walls: a bead that meets one between two kicks turns back there, with the component across the wall reversed
// (specular: the wall slips) or the whole velocity (bounce-back: no slip). Any number of bounces in one flight.
#pragma once

#include <algorithm>
#include <limits>

#include "external/flight.hpp"
#include "external/wall_planes.hpp"

namespace dlpoly {

class HardWalls final : public Flight {
  public:
    HardWalls(const WallPlanes& planes, bool bounce_back) : planes_(planes), bounce_back_(bounce_back) {}

    [[nodiscard]] Vector3 move(Particles& particles, Eigen::Index bead, double time) const override {
        constexpr int most_bounces = 100000;
        Vector3 position = particles.position.row(bead).transpose();
        if (particles.frozen[static_cast<std::size_t>(bead)] != 0) {
            return position;
        }
        Vector3 velocity = particles.velocity.row(bead).transpose();
        for (int bounces = 0; bounces < most_bounces; ++bounces) {
            double until = time;
            const Eigen::Index axis = next_wall(position, velocity, until);
            position += until * velocity;
            time -= until;
            if (axis < 0) {
                particles.velocity.row(bead) = velocity.transpose();
                return clamped(position);
            }
            if (bounce_back_) {
                velocity = -velocity;
            } else {
                velocity[axis] = -velocity[axis];
            }
        }
        return Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
    }

  private:
    // The axis of the wall that is met first within the time, and when; −1 when none is.
    [[nodiscard]] Eigen::Index next_wall(const Vector3& position, const Vector3& velocity, double& until) const {
        Eigen::Index met = -1;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            if (!planes_.walled[static_cast<std::size_t>(axis)] || velocity[axis] == 0.0) {
                continue;
            }
            const double wall = velocity[axis] > 0.0 ? planes_.distance[axis] : -planes_.distance[axis];
            const double time = std::max(0.0, (wall - position[axis]) / velocity[axis]);
            if (time < until) {
                until = time;
                met = axis;
            }
        }
        return met;
    }

    // Rounding may leave a bead beyond a wall by its last digit.
    [[nodiscard]] Vector3 clamped(Vector3 position) const {
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            if (planes_.walled[static_cast<std::size_t>(axis)]) {
                position[axis] = std::clamp(position[axis], -planes_.distance[axis], planes_.distance[axis]);
            }
        }
        return position;
    }

    WallPlanes planes_;
    bool bounce_back_;
};

}  // namespace dlpoly
