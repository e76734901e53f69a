// Angle law mmbd: MM3's polynomial of sixth degree in d = θ − θ0.
//
// The coefficients are those of MM3 for degrees, but d is in radians, as in DL_POLY's code: the energies agree with
// its files.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class Mm3Angle {
    static constexpr std::array<std::string_view, 2> names{"k", "th0"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::angle,
        .key = "mmbd",
        .restraint_key = "-mbd",
        .description = "MM3, k d^2 [1 - 0.014 d + 5.6e-5 d^2 - 7e-7 d^3 + 2.2e-8 d^4], d = th - th0",
        .parameter_names = names,
        .energy_mask = 0b1,
        .degree_mask = 0b10};

    explicit Mm3Angle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
    }

    AngleValue operator()(double angle, double /*first*/, double /*second*/) const noexcept {
        constexpr double c1 = 0.014, c2 = 5.6e-5, c3 = 7e-7, c4 = 2.2e-8;
        const double d = angle - angle_;
        const double energy = 1.0 - d * (c1 - d * (c2 - d * (c3 - d * c4)));
        const double slope = 2.0 - d * (3.0 * c1 - d * (4.0 * c2 - d * (5.0 * c3 - d * 6.0 * c4)));
        return {stiffness_ * d * d * energy, stiffness_ * d * slope};
    }

  private:
    double stiffness_, angle_;
};

}  // namespace dlpoly::bonded
