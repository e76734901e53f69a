// Pair law buck: U = A exp(−r/rho) − C/r⁶.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/tail.hpp"

namespace dlpoly::pair {

class Buckingham {
    static constexpr std::array<std::string_view, 3> names{"A", "rho", "C"};

  public:
    static constexpr LawInfo info{.key = "buck",
                                  .description = "Buckingham, A exp(-r/rho) - C/r^6",
                                  .parameter_names = names,
                                  .energy_mask = 0b101,
                                  .drag_slot = 4,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    Buckingham(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        repulsion_ = given.any(0);
        // As in DL_POLY, a pair of dispersion only may leave A and rho at zero.
        const double decay = given.not_negative(1);
        given.require(decay > 0.0 || repulsion_ == 0.0, 1, "a positive number when A is not zero");
        inverse_decay_ = decay > 0.0 ? 1.0 / decay : 1.0;
        dispersion_ = given.any(2);
    }

    double range() const noexcept { return 0.0; }

    // DL_POLY corrects for the dispersion only: the exponential is taken to have died out at the cutoff.
    Tail tail(double cutoff) const noexcept {
        const double cube = cutoff * cutoff * cutoff;
        return {-dispersion_ / (3.0 * cube), 2.0 * dispersion_ / cube};
    }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double inverse = 1.0 / distance;
        const double inverse_square = inverse * inverse;
        const double repulsive = repulsion_ * std::exp(-distance * inverse_decay_);
        const double attractive = dispersion_ * inverse_square * inverse_square * inverse_square;
        return {repulsive - attractive, repulsive * inverse_decay_ * inverse - 6.0 * attractive * inverse_square};
    }

  private:
    double repulsion_, inverse_decay_, dispersion_;
};

}  // namespace dlpoly::pair
