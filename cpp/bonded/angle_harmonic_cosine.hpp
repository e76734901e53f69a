// Angle law hcos: U = ½ k (cos θ − cos θ0)².
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class HarmonicCosineAngle {
    static constexpr std::array<std::string_view, 2> names{"k", "th0"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "hcos",
                                  .restraint_key = "-hcs",
                                  .description = "harmonic in the cosine, k/2 (cos th - cos th0)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit HarmonicCosineAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        cosine_ = std::cos(given.any(1));
    }

    AngleValue operator()(double angle, double /*first*/, double /*second*/) const noexcept {
        const double bend = std::cos(angle) - cosine_;
        return {0.5 * stiffness_ * bend * bend, -stiffness_ * bend * std::sin(angle)};
    }

  private:
    double stiffness_, cosine_;
};

}  // namespace dlpoly::bonded
