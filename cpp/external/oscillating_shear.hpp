// Oscillating shear in space, DL_POLY's `oshr`: F_x = A cos(2 n π z / L_z), the same for every bead whatever its mass.
#pragma once

#include <cmath>
#include <stdexcept>

#include "external/external_field.hpp"

namespace dlpoly {

class OscillatingShear final : public ExternalField {
  public:
    explicit OscillatingShear(std::span<const double> parameters) {
        if (parameters.size() < 2) {
            throw std::invalid_argument("the external field oshr needs two numbers: A n");
        }
        amplitude_ = parameters[0];
        waves_ = parameters[1];
    }

    double add(const Box& box, Particles& particles, double /*time*/) const override {
        const double wave_number = 2.0 * pi * waves_ / box.cell()(2, 2);
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
                particles.force(i, 0) += amplitude_ * std::cos(wave_number * particles.position(i, 2));
            }
        }
        return 0.0;
    }

  private:
    double amplitude_ = 0.0;
    double waves_ = 0.0;
};

}  // namespace dlpoly
