// Angle law quar: a quartic spring, U = k/2 d² + k'/3 d³ + k''/4 d⁴ with d = θ − θ0.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class QuarticAngle {
    static constexpr std::array<std::string_view, 4> names{"k", "th0", "k'", "k''"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "quar",
                                  .restraint_key = "-qur",
                                  .description = "quartic, k/2 d^2 + k'/3 d^3 + k''/4 d^4, d = th - th0",
                                  .parameter_names = names,
                                  .energy_mask = 0b1101,
                                  .degree_mask = 0b10};

    explicit QuarticAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        second_ = given.any(0);
        angle_ = given.any(1);
        third_ = given.any(2);
        fourth_ = given.any(3);
    }

    AngleValue operator()(double angle, double /*first*/, double /*second*/) const noexcept {
        const double d = angle - angle_;
        return {d * d * (0.5 * second_ + d * (third_ / 3.0 + 0.25 * fourth_ * d)),
                d * (second_ + d * (third_ + fourth_ * d))};
    }

  private:
    double second_, angle_, third_, fourth_;
};

}  // namespace dlpoly::bonded
