// Tether law harm: a spring, U = ½ k d².
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class HarmonicTether {
    static constexpr std::array<std::string_view, 1> names{"k"};

  public:
    static constexpr LawInfo info{.kind = Kind::tether,
                                  .key = "harm",
                                  .restraint_key = "",
                                  .description = "spring, k/2 d^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit HarmonicTether(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
    }

    Value operator()(double length) const noexcept { return {0.5 * stiffness_ * length * length, stiffness_ * length}; }

  private:
    double stiffness_;
};

}  // namespace dlpoly::bonded
