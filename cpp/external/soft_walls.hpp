// Soft walls: U = ½ A r_c (1 − d/r_c)² for a bead at the distance d < r_c from a wall, the form of the soft repulsion
// of pairs; A belongs to the bead's species.
#pragma once

#include <stdexcept>
#include <utility>
#include <vector>

#include "external/external_field.hpp"
#include "external/wall_planes.hpp"

namespace dlpoly {

class SoftWalls final : public ExternalField {
  public:
    // strengths: A by species, Da Å/ps²; range: r_c, Å.
    SoftWalls(const WallPlanes& planes, std::vector<double> strengths, double range)
        : planes_(planes), strengths_(std::move(strengths)), range_(range) {
        if (!(range > 0.0)) {
            throw std::invalid_argument("the range of a soft wall must be larger than 0");
        }
    }

    double add(const Box& /*box*/, Particles& particles, double /*time*/) const override {
        double energy = 0.0;
        visit(particles, [&](Eigen::Index bead, Eigen::Index axis, double inwards, double strength, double distance) {
            const double closeness = 1.0 - distance / range_;
            particles.force(bead, axis) += inwards * strength * closeness;
            energy += 0.5 * strength * range_ * closeness * closeness;
        });
        return energy;
    }

    [[nodiscard]] double curvature(const Particles& particles) const override {
        double sum = 0.0;
        visit(particles,
              [&](Eigen::Index, Eigen::Index, double, double strength, double) { sum += strength / range_; });
        return sum;
    }

  private:
    // Calls act(bead, axis, direction into the cell, A, distance) for every bead near a wall.
    template <class Act>
    void visit(const Particles& particles, const Act& act) const {
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            if (particles.frozen[static_cast<std::size_t>(i)] != 0) {
                continue;
            }
            const auto species = static_cast<std::size_t>(particles.species[static_cast<std::size_t>(i)]);
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                if (!planes_.walled[static_cast<std::size_t>(axis)]) {
                    continue;
                }
                for (const double inwards : {1.0, -1.0}) {
                    const double distance = planes_.distance[axis] + inwards * particles.position(i, axis);
                    if (distance < range_) {
                        act(i, axis, inwards, strengths_[species], distance);
                    }
                }
            }
        }
    }

    WallPlanes planes_;
    std::vector<double> strengths_;
    double range_;
};

}  // namespace dlpoly
