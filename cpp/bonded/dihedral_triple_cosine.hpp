// Dihedral law cos3: U = ½ {A1 (1 + cos φ) + A2 (1 − cos 2φ) + A3 (1 + cos 3φ)}.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class TripleCosineDihedral {
    static constexpr std::array<std::string_view, 3> names{"A1", "A2", "A3"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::dihedral,
        .key = "cos3",
        .restraint_key = "-cs3",
        .description = "three cosines, 1/2 {A1 (1 + cos phi) + A2 (1 - cos 2 phi) + A3 (1 + cos 3 phi)}",
        .parameter_names = names,
        .energy_mask = 0b111};

    explicit TripleCosineDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        first_ = 0.5 * given.any(0);
        second_ = 0.5 * given.any(1);
        third_ = 0.5 * given.any(2);
    }

    Value operator()(double angle) const noexcept {
        const double energy = first_ * (1.0 + std::cos(angle)) + second_ * (1.0 - std::cos(2.0 * angle)) +
                              third_ * (1.0 + std::cos(3.0 * angle));
        const double slope =
            -first_ * std::sin(angle) + 2.0 * second_ * std::sin(2.0 * angle) - 3.0 * third_ * std::sin(3.0 * angle);
        return {energy, slope};
    }

  private:
    double first_, second_, third_;
};

}  // namespace dlpoly::bonded
