// Periodic Poiseuille flow, our own `pois`: F_x = m g sign(y), so that the fluid flows one way in one half of the cell
// and the other way in the other half, with v_x = g ρ y (½L_y − y)/(2η) between y = 0 and ½L_y. Backer, Lowe, Hoefsloot
// and Iedema, J. Chem. Phys. 122, 154503 (2005).
#pragma once

#include <stdexcept>

#include "external/external_field.hpp"

namespace dlpoly {

class OppositeHalves final : public ExternalField {
  public:
    explicit OppositeHalves(std::span<const double> parameters) {
        if (parameters.empty()) {
            throw std::invalid_argument("the external field pois needs a number: g");
        }
        acceleration_ = parameters[0];
    }

    double add(const Box& /*box*/, Particles& particles, double /*time*/) const override {
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
                const double force = particles.mass[static_cast<std::size_t>(i)] * acceleration_;
                particles.force(i, 0) += particles.position(i, 1) < 0.0 ? -force : force;
            }
        }
        return 0.0;
    }

  private:
    double acceleration_ = 0.0;
};

}  // namespace dlpoly
