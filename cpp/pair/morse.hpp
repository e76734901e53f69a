// Pair law mors: U = E0 {[1 − exp(−k(r − r0))]² − 1}.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class Morse {
    static constexpr std::array<std::string_view, 3> names{"E0", "r0", "k"};

  public:
    static constexpr LawInfo info{.key = "mors",
                                  .description = "Morse, E0 {[1 - exp(-k (r - r0))]^2 - 1}",
                                  .parameter_names = names,
                                  .energy_mask = 0b001,
                                  .drag_slot = 4,
                                  .soft = true,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    Morse(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        depth_ = given.any(0);
        minimum_ = given.not_negative(1);
        rate_ = given.positive(2);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double decay = std::exp(rate_ * (minimum_ - distance));
        return {depth_ * decay * (decay - 2.0),
                2.0 * depth_ * rate_ * decay * (decay - 1.0) * inverse_or_zero(distance)};
    }

  private:
    double depth_, minimum_, rate_;
};

}  // namespace dlpoly::pair
