// Inversion law harm: a spring, U = ½ k (φ − φ0)².
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class HarmonicInversion {
    static constexpr std::array<std::string_view, 2> names{"k", "phi0"};

  public:
    static constexpr LawInfo info{.kind = Kind::inversion,
                                  .key = "harm",
                                  .restraint_key = "-hrm",
                                  .description = "spring, k/2 (phi - phi0)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit HarmonicInversion(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
    }

    Value operator()(double angle) const noexcept {
        const double bend = angle - angle_;
        return {0.5 * stiffness_ * bend * bend, stiffness_ * bend};
    }

  private:
    double stiffness_, angle_;
};

}  // namespace dlpoly::bonded
