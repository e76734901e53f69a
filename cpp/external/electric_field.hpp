// A uniform electric field, DL_POLY's `elec`: F = q E, and one that oscillates in time, `osel`: F = q E sin(2π f t).
#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "external/external_field.hpp"

namespace dlpoly {

class ElectricField final : public ExternalField {
  public:
    // parameters: Ex Ey Ez as forces on a charge of 1 and, where it oscillates, f in 1/ps; charges: one a bead, e.
    ElectricField(std::span<const double> parameters, std::vector<double> charges, bool oscillates)
        : charges_(std::move(charges)), oscillates_(oscillates) {
        if (parameters.size() < (oscillates ? 4 : 3)) {
            throw std::invalid_argument(oscillates ? "the external field osel needs four numbers: Ex Ey Ez f"
                                                   : "the external field elec needs three numbers: Ex Ey Ez");
        }
        field_ = {parameters[0], parameters[1], parameters[2]};
        frequency_ = oscillates ? parameters[3] : 0.0;
    }

    double add(const Box& /*box*/, Particles& particles, double time) const override {
        const Vector3 field = oscillates_ ? Vector3(field_ * std::sin(2.0 * pi * frequency_ * time)) : field_;
        for (std::size_t i = 0; i < charges_.size(); ++i) {
            if (particles.frozen[i] == 0) {
                particles.force.row(static_cast<Eigen::Index>(i)) += charges_[i] * field.transpose();
            }
        }
        return 0.0;
    }

  private:
    Vector3 field_;
    double frequency_ = 0.0;
    std::vector<double> charges_;
    bool oscillates_;
};

}  // namespace dlpoly
