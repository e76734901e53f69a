// Pair law hbnd: U = A/r¹² − B/r¹⁰.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class HydrogenBond {
    static constexpr std::array<std::string_view, 2> names{"A", "B"};

  public:
    static constexpr LawInfo info{.key = "hbnd",
                                  .description = "hydrogen bond 12-10, A/r^12 - B/r^10",
                                  .parameter_names = names,
                                  .energy_mask = 0b11,
                                  .drag_slot = 3,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    HydrogenBond(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        repulsion_ = given.any(0);
        attraction_ = given.any(1);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double inverse_square = 1.0 / distance_squared;
        const double inverse_fourth = inverse_square * inverse_square;
        const double inverse_tenth = inverse_fourth * inverse_fourth * inverse_square;
        const double repulsive = repulsion_ * inverse_square;
        return {inverse_tenth * (repulsive - attraction_),
                inverse_tenth * inverse_square * (12.0 * repulsive - 10.0 * attraction_)};
    }

  private:
    double repulsion_, attraction_;
};

}  // namespace dlpoly::pair
