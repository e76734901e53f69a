// Pair law ryd: U = (a + b r) exp(−r/rho).
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class Rydberg {
    static constexpr std::array<std::string_view, 3> names{"a", "b", "rho"};

  public:
    static constexpr LawInfo info{.key = "ryd",
                                  .description = "Rydberg, (a + b r) exp(-r/rho)",
                                  .parameter_names = names,
                                  .energy_mask = 0b011,
                                  .drag_slot = 4,
                                  .soft = true,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    Rydberg(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        constant_ = given.any(0);
        linear_ = given.any(1);
        inverse_decay_ = 1.0 / given.positive(2);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double decay = std::exp(-distance * inverse_decay_);
        const double energy = (constant_ + linear_ * distance) * decay;
        return {energy, (energy * inverse_decay_ - linear_ * decay) * inverse_or_zero(distance)};
    }

  private:
    double constant_, linear_, inverse_decay_;
};

}  // namespace dlpoly::pair
