// Pair law 14-7: the buffered potential of Halgren (AMOEBA).
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class FourteenSeven {
    static constexpr std::array<std::string_view, 2> names{"eps", "r0"};

  public:
    static constexpr LawInfo info{
        .key = "14-7",
        .description = "buffered 14-7 (AMOEBA), eps [1.07/(q+0.07)]^7 [1.12/(q^7+0.12) - 2], q = r/r0",
        .parameter_names = names,
        .energy_mask = 0b01,
        .drag_slot = 3,
        .soft = true,
        .has_tail = true,
        .mixable = true,
        .shiftable = true};

    FourteenSeven(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        depth_ = given.any(0);
        inverse_minimum_ = 1.0 / given.positive(1);
    }

    double range() const noexcept { return 0.0; }

    // The long-range correction is the integral. DL_POLY's own differs from it by 3e-5 (energy) and 2e-3 (virial): its
    // Simpson sum counts one panel in every block twice, and its slope has the wrong sign in one term.
    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double q = distance * inverse_minimum_;
        const double q_sixth = sixth_power(q);
        const double inverse_sum = 1.0 / (q + 0.07);
        const double buffer = 1.07 * inverse_sum;
        const double outer = depth_ * sixth_power(buffer) * buffer;
        const double inverse_inner = 1.0 / (q_sixth * q + 0.12);
        const double inner = 1.12 * inverse_inner;
        const double slope = (inner - 2.0) * inverse_sum + inner * inverse_inner * q_sixth;  // −dU/dq = 7 outer slope
        return {outer * (inner - 2.0), 7.0 * outer * slope * inverse_minimum_ * inverse_or_zero(distance)};
    }

  private:
    double depth_, inverse_minimum_;
};

}  // namespace dlpoly::pair
