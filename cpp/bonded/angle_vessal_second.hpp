// Angle law bvs2: truncated Vessal, U = k [θᵃ q² s² − ½ a πᵃ⁻¹ q² (π − θ0)³] exp[−(rij⁸ + rjk⁸)/rho⁸] with q = θ − θ0,
// s = θ + θ0 − 2π.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

class SecondVessalAngle {
    static constexpr std::array<std::string_view, 4> names{"k", "th0", "a", "rho"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "bvs2",
                                  .restraint_key = "-bv2",
                                  .description =
                                      "truncated Vessal, k [th^a q^2 s^2 - a/2 pi^(a-1) q^2 (pi - th0)^3] exp[-(rij^8 "
                                      "+ rjk^8)/rho^8], q = th - th0, s = th + th0 - 2 pi",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10,
                                  .limit = "the beads fold back on each other, where th^a has no bound"};

    explicit SecondVessalAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        angle_ = given.any(1);
        exponent_ = given.any(2);
        inverse_range_ = 1.0 / given.positive(3);
        constant_ = 0.5 * exponent_ * std::pow(pi, exponent_ - 1.0) * std::pow(pi - angle_, 3);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double q = angle - angle_;
        const double s = angle + angle_ - 2.0 * pi;
        const double power = std::pow(angle, exponent_);
        const double power_slope = exponent_ == 0.0 ? 0.0 : exponent_ * std::pow(angle, exponent_ - 1.0);
        const double a = std::pow(first * inverse_range_, 7);
        const double b = std::pow(second * inverse_range_, 7);
        const double fade = strength_ * std::exp(-(a * first + b * second) * inverse_range_);
        const double energy = fade * q * q * (power * s * s - constant_);
        const double by_angle = q * (power_slope * q * s * s + 2.0 * power * s * (s + q) - 2.0 * constant_);
        const double slope = -8.0 * inverse_range_ * energy;
        return {energy, fade * by_angle, slope * a, slope * b};
    }

  private:
    double strength_, angle_, exponent_, inverse_range_, constant_;
};

}  // namespace dlpoly::bonded
