// Dihedral law ryck: Ryckaert and Bellemans' alkanes, a polynomial of fifth degree in cos φ with trans at 180 degrees.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class RyckaertBellemansDihedral {
    static constexpr std::array<std::string_view, 1> names{"A"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::dihedral,
        .key = "ryck",
        .restraint_key = "-rck",
        .description =
            "Ryckaert-Bellemans, A (1.116 - 1.462 c - 1.578 c^2 + 0.368 c^3 + 3.156 c^4 + 3.788 c^5), c = cos phi",
        .parameter_names = names,
        .energy_mask = 0b1};

    explicit RyckaertBellemansDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
    }

    Value operator()(double angle) const noexcept {
        const double c = std::cos(angle);
        const double energy = 1.116 + c * (-1.462 + c * (-1.578 + c * (0.368 + c * (3.156 + c * 3.788))));
        const double slope = -1.462 + c * (-2.0 * 1.578 + c * (3.0 * 0.368 + c * (4.0 * 3.156 + c * 5.0 * 3.788)));
        return {strength_ * energy, -strength_ * slope * std::sin(angle)};
    }

  private:
    double strength_;
};

}  // namespace dlpoly::bonded
