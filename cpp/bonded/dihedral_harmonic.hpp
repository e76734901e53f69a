// Dihedral law harm: a spring, U = ½ k (φ − φ0)², the difference taken the short way round.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

class HarmonicDihedral {
    static constexpr std::array<std::string_view, 2> names{"k", "phi0"};

  public:
    static constexpr LawInfo info{.kind = Kind::dihedral,
                                  .key = "harm",
                                  .restraint_key = "-hrm",
                                  .description = "spring, k/2 (phi - phi0)^2, the short way round",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit HarmonicDihedral(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        angle_ = given.any(1);
    }

    Value operator()(double angle) const noexcept {
        const double difference = angle - angle_;
        const double twist = difference - 2.0 * pi * std::rint(difference / (2.0 * pi));
        return {0.5 * stiffness_ * twist * twist, stiffness_ * twist};
    }

  private:
    double stiffness_, angle_;
};

}  // namespace dlpoly::bonded
