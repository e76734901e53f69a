// Angle law stbe: U = A (θ − θ0)(rij − r1).
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class StretchBendAngle {
    static constexpr std::array<std::string_view, 3> names{"A", "th0", "r1"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "stbe",
                                  .restraint_key = "-stb",
                                  .description = "stretch-bend, A (th - th0)(rij - r1)",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit StretchBendAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        angle_ = given.any(1);
        first_ = given.any(2);
    }

    AngleValue operator()(double angle, double first, double /*second*/) const noexcept {
        const double bend = strength_ * (angle - angle_);
        const double a = first - first_;
        return {bend * a, strength_ * a, bend, 0.0};
    }

  private:
    double strength_, angle_, first_;
};

}  // namespace dlpoly::bonded
