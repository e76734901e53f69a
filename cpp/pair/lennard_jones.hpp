// Pair law lj: U = 4 eps [(sig/r)¹² − (sig/r)⁶].
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/twelve_six_terms.hpp"

namespace dlpoly::pair {

class LennardJones {
    static constexpr std::array<std::string_view, 2> names{"eps", "sig"};

  public:
    static constexpr LawInfo info{.key = "lj",
                                  .description = "Lennard-Jones, 4 eps [(sig/r)^12 - (sig/r)^6]",
                                  .parameter_names = names,
                                  .energy_mask = 0b01,
                                  .drag_slot = 3,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = true,
                                  .shiftable = true};

    LennardJones(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        const double sixth = sixth_power(given.not_negative(1));
        terms_ = {4.0 * given.any(0) * sixth * sixth, 4.0 * given.any(0) * sixth};
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return terms_(distance_squared); }

  private:
    TwelveSixTerms terms_;
};

}  // namespace dlpoly::pair
