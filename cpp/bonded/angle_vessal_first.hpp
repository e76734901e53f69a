// Angle law bvs1: screened Vessal, U = k/(8 (θ0 − π)²) [(θ0 − π)² − (θ − π)²]² exp[−(rij/rho1 + rjk/rho2)].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

class FirstVessalAngle {
    static constexpr std::array<std::string_view, 4> names{"k", "th0", "rho1", "rho2"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::angle,
        .key = "bvs1",
        .restraint_key = "-bv1",
        .description = "screened Vessal, k/(8 (th0 - pi)^2) [(th0 - pi)^2 - (th - pi)^2]^2 exp[-(rij/rho1 + rjk/rho2)]",
        .parameter_names = names,
        .energy_mask = 0b1,
        .degree_mask = 0b10};

    explicit FirstVessalAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        given.require(given.any(1) != pi, 1, "another angle than 180 degrees");
        square_ = (given.any(1) - pi) * (given.any(1) - pi);
        strength_ = given.any(0) / (8.0 * square_);
        inverse_first_ = 1.0 / given.positive(2);
        inverse_second_ = 1.0 / given.positive(3);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double open = angle - pi;
        const double difference = square_ - open * open;
        const double fade = strength_ * std::exp(-(first * inverse_first_ + second * inverse_second_));
        const double energy = fade * difference * difference;
        return {energy, -4.0 * fade * difference * open, -energy * inverse_first_, -energy * inverse_second_};
    }

  private:
    double square_, strength_, inverse_first_, inverse_second_;
};

}  // namespace dlpoly::bonded
