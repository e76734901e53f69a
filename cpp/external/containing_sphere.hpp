// A sphere about the origin that beads cannot leave, DL_POLY's `sphr`: U = A (R₀ − r)^(−n) for r > R_cut. The force is
// the slope of this energy, n A (R₀ − r)^(−n−1) inwards; DL_POLY 5.2 divides once more by R₀ − r and multiplies by r.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/failure.hpp"
#include "external/external_field.hpp"

namespace dlpoly {

class ContainingSphere final : public ExternalField {
  public:
    explicit ContainingSphere(std::span<const double> parameters) {
        if (parameters.size() < 4) {
            throw std::invalid_argument("the external field sphr needs four numbers: A R0 n Rcut");
        }
        strength_ = parameters[0];
        radius_ = parameters[1];
        power_ = parameters[2];
        begin_ = parameters[3];
        if (!(power_ > 0.0) || !(begin_ >= 0.0) || !(radius_ > begin_)) {
            throw std::invalid_argument("the external field sphr needs n above 0 and Rcut in 0 to R0");
        }
    }

    double add(const Box& /*box*/, Particles& particles, double /*time*/) const override {
        double energy = 0.0;
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            const double distance = particles.position.row(i).norm();
            if (particles.frozen[static_cast<std::size_t>(i)] != 0 || !(distance > begin_)) {
                continue;
            }
            const double gap = radius_ - distance;
            if (!(gap > 0.0)) {
                throw RunFailure("bead " + std::to_string(i + 1) + " is outside the sphere of the external field sphr");
            }
            const double here = strength_ * std::pow(gap, -power_);
            energy += here;
            particles.force.row(i) -= power_ * here / (gap * distance) * particles.position.row(i);
        }
        return energy;
    }

    [[nodiscard]] double curvature(const Particles& particles) const override {
        double sum = 0.0;
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            const double distance = particles.position.row(i).norm();
            const double gap = radius_ - distance;
            if (particles.frozen[static_cast<std::size_t>(i)] == 0 && distance > begin_) {
                const double slope = power_ * strength_ * std::pow(gap, -power_ - 1.0);
                sum += slope * ((power_ + 1.0) / gap + 2.0 / distance);
            }
        }
        return sum;
    }

  private:
    double strength_ = 0.0;
    double radius_ = 0.0;
    double power_ = 0.0;
    double begin_ = 0.0;
};

}  // namespace dlpoly
