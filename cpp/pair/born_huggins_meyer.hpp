// Pair law bhm: U = A exp[B(sig − r)] − C/r⁶ − D/r⁸.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/tail.hpp"

namespace dlpoly::pair {

class BornHugginsMeyer {
    static constexpr std::array<std::string_view, 5> names{"A", "B", "sig", "C", "D"};

  public:
    static constexpr LawInfo info{.key = "bhm",
                                  .description = "Born-Huggins-Meyer, A exp[B (sig - r)] - C/r^6 - D/r^8",
                                  .parameter_names = names,
                                  .energy_mask = 0b11001,
                                  .drag_slot = 6,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    BornHugginsMeyer(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        rate_ = given.not_negative(1);
        given.require(rate_ > 0.0 || given.any(0) == 0.0, 1, "a positive number when A is not zero");
        repulsion_ = given.any(0);
        contact_ = given.any(2);
        sixth_ = given.any(3);
        eighth_ = given.any(4);
    }

    double range() const noexcept { return 0.0; }

    // DL_POLY corrects for the dispersion only: the exponential is taken to have died out at the cutoff.
    Tail tail(double cutoff) const noexcept {
        const double sixth = sixth_ / (cutoff * cutoff * cutoff);
        const double eighth = eighth_ / (cutoff * cutoff * cutoff * cutoff * cutoff);
        return {-sixth / 3.0 - eighth / 5.0, 2.0 * sixth + 1.6 * eighth};
    }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double inverse = 1.0 / distance;
        const double inverse_square = inverse * inverse;
        const double repulsive = repulsion_ * std::exp(rate_ * (contact_ - distance));
        const double inverse_sixth = inverse_square * inverse_square * inverse_square;
        const double sixth = sixth_ * inverse_sixth;
        const double eighth = eighth_ * inverse_sixth * inverse_square;
        return {repulsive - sixth - eighth,
                repulsive * rate_ * inverse - (6.0 * sixth + 8.0 * eighth) * inverse_square};
    }

  private:
    double repulsion_, rate_, contact_, sixth_, eighth_;
};

}  // namespace dlpoly::pair
