// Angle law harm: a spring, U = ½ k (θ − θ0)².
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class HarmonicAngle {
    static constexpr std::array<std::string_view, 2> names{"k", "th0"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "harm",
                                  .restraint_key = "-hrm",
                                  .description = "spring, k/2 (th - th0)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit HarmonicAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
    }

    AngleValue operator()(double angle, double /*first*/, double /*second*/) const noexcept {
        const double bend = angle - angle_;
        return {0.5 * stiffness_ * bend * bend, stiffness_ * bend};
    }

  private:
    double stiffness_, angle_;
};

}  // namespace dlpoly::bonded
