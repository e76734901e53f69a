// Dihedral law rbf: fluorinated Ryckaert-Bellemans (Rice et al. 1996), with a narrow hill at trans.
//
// The hill is centred on trans from both sides. DL_POLY's code has only the side of positive φ, so that its energy
// jumps at 180 degrees.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

class FluorinatedRyckaertDihedral {
    static constexpr std::array<std::string_view, 1> names{"A"};

  public:
    static constexpr LawInfo info{.kind = Kind::dihedral,
                                  .key = "rbf",
                                  .restraint_key = "-rbf",
                                  .description =
                                      "fluorinated Ryckaert-Bellemans, A (3.55 - 2.78 c - 3.56 c^2 - 1.64 c^3 + 7.13 "
                                      "c^4 + 12.84 c^5 + 9.67 exp[-56 (phi - pi)^2]), c = cos phi",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit FluorinatedRyckaertDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
    }

    Value operator()(double angle) const noexcept {
        const double c = std::cos(angle);
        const double energy = 3.55 + c * (-2.78 + c * (-3.56 + c * (-1.64 + c * (7.13 + c * 12.84))));
        const double slope = -2.78 + c * (-2.0 * 3.56 + c * (-3.0 * 1.64 + c * (4.0 * 7.13 + c * 5.0 * 12.84)));
        const double from_trans = angle > 0.0 ? angle - pi : angle + pi;
        const double hill = 9.67 * std::exp(-56.0 * from_trans * from_trans);
        return {strength_ * (energy + hill), -strength_ * (slope * std::sin(angle) + 112.0 * from_trans * hill)};
    }

  private:
    double strength_;
};

}  // namespace dlpoly::bonded
