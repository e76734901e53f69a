// Angle law kky: Kumagai-Kawamura-Yokokawa, U = 2 f √(Kij Kjk) sin²(θ − θ0), K(r) = 1/(exp[g (r − ro)] + 1).
//
// As documented, and as it must be to fade with distance; DL_POLY's code multiplies by the inverse of the root.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class KumagaiAngle {
    static constexpr std::array<std::string_view, 4> names{"fk", "th0", "gr", "ro"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::angle,
        .key = "kky",
        .restraint_key = "-kky",
        .description = "Kumagai-Kawamura-Yokokawa, 2 fk sqrt(Kij Kjk) sin^2(th - th0), K = 1/(exp[gr (r - ro)] + 1)",
        .parameter_names = names,
        .energy_mask = 0b1,
        .degree_mask = 0b10};

    explicit KumagaiAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        angle_ = given.any(1);
        steepness_ = given.any(2);
        length_ = given.any(3);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double bend = angle - angle_;
        const double a = 1.0 / (std::exp(steepness_ * (first - length_)) + 1.0);
        const double b = 1.0 / (std::exp(steepness_ * (second - length_)) + 1.0);
        const double fade = 2.0 * strength_ * std::sqrt(a * b);
        const double sine = std::sin(bend);
        const double energy = fade * sine * sine;
        const double slope = -0.5 * steepness_ * energy;
        return {energy, fade * std::sin(2.0 * bend), slope * (1.0 - a), slope * (1.0 - b)};
    }

  private:
    double strength_, angle_, steepness_, length_;
};

}  // namespace dlpoly::bonded
