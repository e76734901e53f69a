// Dihedral law opls: U = A0 + ½ {A1 (1 + cos f) + A2 (1 − cos 2f) + A3 (1 + cos 3f)} with f = φ − φ0.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class OplsDihedral {
    static constexpr std::array<std::string_view, 5> names{"A0", "A1", "A2", "A3", "phi0"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::dihedral,
        .key = "opls",
        .restraint_key = "-opl",
        .description = "OPLS, A0 + 1/2 {A1 (1 + cos f) + A2 (1 - cos 2 f) + A3 (1 + cos 3 f)}, f = phi - phi0",
        .parameter_names = names,
        .energy_mask = 0b1111,
        .degree_mask = 0b10000,
        .optional = 1};

    explicit OplsDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        constant_ = given.any(0);
        first_ = 0.5 * given.any(1);
        second_ = 0.5 * given.any(2);
        third_ = 0.5 * given.any(3);
        angle_ = given.any(4);
    }

    Value operator()(double angle) const noexcept {
        const double f = angle - angle_;
        const double energy =
            first_ * (1.0 + std::cos(f)) + second_ * (1.0 - std::cos(2.0 * f)) + third_ * (1.0 + std::cos(3.0 * f));
        const double slope =
            -first_ * std::sin(f) + 2.0 * second_ * std::sin(2.0 * f) - 3.0 * third_ * std::sin(3.0 * f);
        return {constant_ + energy, slope};
    }

  private:
    double constant_, first_, second_, third_, angle_;
};

}  // namespace dlpoly::bonded
