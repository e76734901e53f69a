// Pair law sw: the two-body part of Stillinger and Weber, which ends smoothly at a·sig.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class StillingerWeber {
    static constexpr std::array<std::string_view, 7> names{"eps", "A", "B", "sig", "p", "q", "a"};

  public:
    static constexpr LawInfo info{
        .key = "sw",
        .description = "Stillinger-Weber pair part, A eps [B (sig/r)^p - (sig/r)^q] exp[sig/(r - a sig)]",
        .parameter_names = names,
        .energy_mask = 0b0000001,
        .drag_slot = 8,
        .soft = false,
        .has_tail = false,
        .mixable = false,
        .shiftable = true};

    StillingerWeber(std::span<const double> parameters, double cutoff)
        : StillingerWeber(Parameters(info, parameters, cutoff)) {}

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        if (distance >= range_) return {};  // saves an exponential and two powers, so worth the branch
        const double inverse = 1.0 / distance;
        const double inverse_gap = 1.0 / (distance - range_);
        const double ratio = sigma_ * inverse;
        const double inner = repulsion_ * inner_(ratio);
        const double outer = attraction_ * outer_(ratio);
        const double screen = std::exp(sigma_ * inverse_gap);
        const double energy = (inner - outer) * screen;
        const double steepness = (inner_.exponent() * inner - outer_.exponent() * outer) * screen * inverse;
        return {energy, (steepness + energy * sigma_ * inverse_gap * inverse_gap) * inverse};
    }

  private:
    explicit StillingerWeber(const Parameters& given)
        : sigma_(given.positive(3)),
          range_(given.positive(6) * sigma_),
          attraction_(given.any(0) * given.any(1)),
          repulsion_(attraction_ * given.any(2)),
          inner_(given.not_negative(4)),
          outer_(given.not_negative(5)) {}

    double sigma_, range_, attraction_, repulsion_;
    Power inner_, outer_;
};

}  // namespace dlpoly::pair
