// Inversion law xpln: U = ½ k [1 − cos(m φ − φ0)].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class ExtendedPlanarInversion {
    static constexpr std::array<std::string_view, 3> names{"k", "m", "phi0"};

  public:
    static constexpr LawInfo info{.kind = Kind::inversion,
                                  .key = "xpln",
                                  .restraint_key = "-xpl",
                                  .description = "extended planar, k/2 [1 - cos(m phi - phi0)]",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b100};

    explicit ExtendedPlanarInversion(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        half_ = 0.5 * given.any(0);
        waves_ = given.any(1);
        phase_ = given.any(2);
    }

    Value operator()(double angle) const noexcept {
        const double argument = waves_ * angle - phase_;
        return {half_ * (1.0 - std::cos(argument)), half_ * waves_ * std::sin(argument)};
    }

  private:
    double half_, waves_, phase_;
};

}  // namespace dlpoly::bonded
