// Continuous shear by two moving slabs, DL_POLY's `shrx`: v_x = ½ A sign(z) for every bead with |z| > z₀. As in DL_POLY
// the velocity is set where the forces of a step are computed, between its two kicks.
#pragma once

#include <cmath>
#include <stdexcept>

#include "external/external_field.hpp"

namespace dlpoly {

class MovingSlabs final : public ExternalField {
  public:
    explicit MovingSlabs(std::span<const double> parameters) {
        if (parameters.size() < 2) {
            throw std::invalid_argument("the external field shrx needs two numbers: A z0");
        }
        speed_ = 0.5 * parameters[0];
        height_ = parameters[1];
    }

    double add(const Box& /*box*/, Particles& /*particles*/, double /*time*/) const override { return 0.0; }

    void steer(Particles& particles) const override {
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            const double z = particles.position(i, 2);
            if (particles.frozen[static_cast<std::size_t>(i)] == 0 && std::abs(z) > height_) {
                particles.velocity(i, 0) = std::copysign(1.0, z) * speed_;
            }
        }
    }

  private:
    double speed_ = 0.0;
    double height_ = 0.0;
};

}  // namespace dlpoly
