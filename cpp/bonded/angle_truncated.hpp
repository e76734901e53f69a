// Angle law thrm: a spring that fades with distance, U = ½ k (θ − θ0)² exp[−(rij⁸ + rjk⁸)/rho⁸].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class TruncatedAngle {
    static constexpr std::array<std::string_view, 3> names{"k", "th0", "rho"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "thrm",
                                  .restraint_key = "-thm",
                                  .description = "truncated spring, k/2 (th - th0)^2 exp[-(rij^8 + rjk^8)/rho^8]",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit TruncatedAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
        inverse_range_ = 1.0 / given.positive(2);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double bend = angle - angle_;
        const double a = std::pow(first * inverse_range_, 7);
        const double b = std::pow(second * inverse_range_, 7);
        const double fade = std::exp(-(a * first + b * second) * inverse_range_);
        const double energy = 0.5 * stiffness_ * bend * bend * fade;
        const double slope = -8.0 * inverse_range_ * energy;
        return {energy, stiffness_ * bend * fade, slope * a, slope * b};
    }

  private:
    double stiffness_, angle_, inverse_range_;
};

}  // namespace dlpoly::bonded
