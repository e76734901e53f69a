// Pair law ljf: the finite-range Lennard-Jones-like law of Wang et al. (2020), smooth at its own rc.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class LennardJonesFrenkel {
    static constexpr std::array<std::string_view, 3> names{"eps", "sig", "rc"};

  public:
    static constexpr LawInfo info{.key = "ljf",
                                  .description = "Lennard-Jones-Frenkel, eps a (sig^2/r^2 - 1)(rc^2/r^2 - 1)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b001,
                                  .drag_slot = 4,
                                  .soft = false,
                                  .has_tail = false,
                                  .mixable = false,
                                  .shiftable = false};

    LennardJonesFrenkel(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        const double sigma = given.positive(1);
        range_ = given.positive(2);
        given.require(range_ > sigma, 2, "greater than sig");
        sigma_squared_ = sigma * sigma;
        range_squared_ = range_ * range_;
        // a puts the minimum at −eps.
        const double ratio = range_squared_ / sigma_squared_;
        const double root = 3.0 / (ratio - 1.0);
        strength_ = given.any(0) * 0.25 * ratio * root * root * root;
    }

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double inverse_square = 1.0 / distance_squared;
        const double core = sigma_squared_ * inverse_square - 1.0;
        const double edge = std::max(0.0, range_squared_ * inverse_square - 1.0);
        const double slope = sigma_squared_ * edge + 2.0 * range_squared_ * core;
        return {strength_ * core * edge * edge, 2.0 * strength_ * edge * slope * inverse_square * inverse_square};
    }

  private:
    double strength_, sigma_squared_, range_squared_, range_;
};

}  // namespace dlpoly::pair
