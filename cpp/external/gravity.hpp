// Uniform gravity, DL_POLY's `grav`: F = m G.
#pragma once

#include <stdexcept>

#include "external/external_field.hpp"

namespace dlpoly {

class Gravity final : public ExternalField {
  public:
    explicit Gravity(std::span<const double> parameters) {
        if (parameters.size() < 3) {
            throw std::invalid_argument("the external field grav needs three numbers: Gx Gy Gz");
        }
        acceleration_ = {parameters[0], parameters[1], parameters[2]};
    }

    double add(const Box& /*box*/, Particles& particles, double /*time*/) const override {
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
                particles.force.row(i) += particles.mass[static_cast<std::size_t>(i)] * acceleration_.transpose();
            }
        }
        return 0.0;
    }

  private:
    Vector3 acceleration_;
};

}  // namespace dlpoly
