// Inversion law plan: U = A (1 − cos φ).
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class PlanarInversion {
    static constexpr std::array<std::string_view, 1> names{"A"};

  public:
    static constexpr LawInfo info{.kind = Kind::inversion,
                                  .key = "plan",
                                  .restraint_key = "-pln",
                                  .description = "planar, A (1 - cos phi)",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit PlanarInversion(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        amplitude_ = given.any(0);
    }

    Value operator()(double angle) const noexcept {
        return {amplitude_ * (1.0 - std::cos(angle)), amplitude_ * std::sin(angle)};
    }

  private:
    double amplitude_;
};

}  // namespace dlpoly::bonded
