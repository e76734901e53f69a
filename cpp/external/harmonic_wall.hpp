// A repulsive harmonic wall across z, DL_POLY's `zbnd`: U = ½ A (z − z₀)² for beads beyond z₀, above it for f = 1,
// below it for f = −1.
#pragma once

#include <cmath>
#include <stdexcept>

#include "external/external_field.hpp"

namespace dlpoly {

class HarmonicWall final : public ExternalField {
  public:
    explicit HarmonicWall(std::span<const double> parameters) {
        if (parameters.size() < 3) {
            throw std::invalid_argument("the external field zbnd needs three numbers: A z0 f");
        }
        stiffness_ = parameters[0];
        height_ = parameters[1];
        side_ = std::copysign(1.0, parameters[2]);
    }

    double add(const Box& /*box*/, Particles& particles, double /*time*/) const override {
        double energy = 0.0;
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            if (acts(particles, i)) {
                const double beyond = particles.position(i, 2) - height_;
                particles.force(i, 2) -= stiffness_ * beyond;
                energy += 0.5 * stiffness_ * beyond * beyond;
            }
        }
        return energy;
    }

    [[nodiscard]] double curvature(const Particles& particles) const override {
        double sum = 0.0;
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            sum += acts(particles, i) ? stiffness_ : 0.0;
        }
        return sum;
    }

  private:
    [[nodiscard]] bool acts(const Particles& particles, Eigen::Index bead) const {
        return particles.frozen[static_cast<std::size_t>(bead)] == 0 &&
               side_ * particles.position(bead, 2) > side_ * height_;
    }

    double stiffness_ = 0.0;
    double height_ = 0.0;
    double side_ = 1.0;
};

}  // namespace dlpoly
