// Dihedral law cos: U = A [1 + cos(m φ − delta)].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class CosineDihedral {
    static constexpr std::array<std::string_view, 3> names{"A", "delta", "m"};

  public:
    static constexpr LawInfo info{.kind = Kind::dihedral,
                                  .key = "cos",
                                  .restraint_key = "-cos",
                                  .description = "cosine, A [1 + cos(m phi - delta)]",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit CosineDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        amplitude_ = given.any(0);
        phase_ = given.any(1);
        waves_ = given.any(2);
    }

    Value operator()(double angle) const noexcept {
        const double argument = waves_ * angle - phase_;
        return {amplitude_ * (1.0 + std::cos(argument)), -amplitude_ * waves_ * std::sin(argument)};
    }

  private:
    double amplitude_, phase_, waves_;
};

}  // namespace dlpoly::bonded
