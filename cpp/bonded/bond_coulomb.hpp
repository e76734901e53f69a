// Bond law coul: Coulomb's, U = k/r; k holds the strength and both charges.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class CoulombBond {
    static constexpr std::array<std::string_view, 1> names{"k"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "coul",
                                  .restraint_key = "-cul",
                                  .description = "Coulomb, k q_i q_j/(4 pi eps0 eps r)",
                                  .parameter_names = names,
                                  .energy_mask = 0,
                                  .limit = "the beads coincide"};

    explicit CoulombBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
    }

    Value operator()(double length) const noexcept {
        const double energy = strength_ / length;
        return {energy, -energy / length};
    }

  private:
    double strength_;
};

}  // namespace dlpoly::bonded
