// Pair law sand: a Gaussian well, U = −A exp{−[(r − L)/d]²}.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class Sanderson {
    static constexpr std::array<std::string_view, 3> names{"A", "L", "d"};

  public:
    static constexpr LawInfo info{.key = "sand",
                                  .description = "Gaussian well, -A exp[-((r - L)/d)^2]",
                                  .parameter_names = names,
                                  .energy_mask = 0b001,
                                  .drag_slot = 4,
                                  .soft = true,
                                  .has_tail = false,
                                  .mixable = false,
                                  .shiftable = true};

    Sanderson(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        depth_ = given.any(0);
        centre_ = given.any(1);
        given.require(given.any(2) != 0.0, 2, "other than zero");
        inverse_width_ = 1.0 / given.any(2);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double x = (distance - centre_) * inverse_width_;
        const double energy = -depth_ * std::exp(-x * x);
        return {energy, 2.0 * energy * x * inverse_width_ * inverse_or_zero(distance)};
    }

  private:
    double depth_, centre_, inverse_width_;
};

}  // namespace dlpoly::pair
