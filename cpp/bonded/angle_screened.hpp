// Angle law shrm: a screened spring, U = ½ k (θ − θ0)² exp[−(rij/rho1 + rjk/rho2)].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class ScreenedAngle {
    static constexpr std::array<std::string_view, 4> names{"k", "th0", "rho1", "rho2"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "shrm",
                                  .restraint_key = "-shm",
                                  .description = "screened spring, k/2 (th - th0)^2 exp[-(rij/rho1 + rjk/rho2)]",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit ScreenedAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
        inverse_first_ = 1.0 / given.positive(2);
        inverse_second_ = 1.0 / given.positive(3);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double bend = angle - angle_;
        const double fade = std::exp(-(first * inverse_first_ + second * inverse_second_));
        const double energy = 0.5 * stiffness_ * bend * bend * fade;
        return {energy, stiffness_ * bend * fade, -energy * inverse_first_, -energy * inverse_second_};
    }

  private:
    double stiffness_, angle_, inverse_first_, inverse_second_;
};

}  // namespace dlpoly::bonded
