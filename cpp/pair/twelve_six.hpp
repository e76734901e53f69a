// Pair law 12-6: U = A/r¹² − B/r⁶.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/twelve_six_terms.hpp"

namespace dlpoly::pair {

class TwelveSix {
    static constexpr std::array<std::string_view, 2> names{"A", "B"};

  public:
    static constexpr LawInfo info{.key = "12-6",
                                  .description = "12-6, A/r^12 - B/r^6",
                                  .parameter_names = names,
                                  .energy_mask = 0b11,
                                  .drag_slot = 3,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = true,
                                  .shiftable = true};

    TwelveSix(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        terms_ = {given.any(0), given.any(1)};
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return terms_(distance_squared); }

  private:
    TwelveSixTerms terms_;
};

}  // namespace dlpoly::pair
