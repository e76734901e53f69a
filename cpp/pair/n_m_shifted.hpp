// Pair law snm: n-m whose energy and force both vanish at its own rc, with the minimum −E0 kept at r0.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class NMShifted {
    static constexpr std::array<std::string_view, 5> names{"E0", "n", "m", "r0", "rc"};

  public:
    static constexpr LawInfo info{.key = "snm",
                                  .description = "shifted-force n-m with its own cutoff rc",
                                  .parameter_names = names,
                                  .energy_mask = 0b00001,
                                  .drag_slot = 6,
                                  .soft = false,
                                  .has_tail = false,
                                  .mixable = false,
                                  .shiftable = false};

    // The law ends at rc. DL_POLY's formula has rc too, but its pre-scan takes r0 for the range and cuts the run there.
    NMShifted(std::span<const double> parameters, double cutoff) : NMShifted(Parameters(info, parameters, cutoff)) {}

    double range() const noexcept { return range_; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::min(std::sqrt(distance_squared), range_);
        const double inverse = 1.0 / distance;
        const double ratio = minimum_ * inverse;
        const double inner = inner_strength_ * inner_(ratio);
        const double outer = outer_strength_ * outer_(ratio);
        const double energy = inner * inverse_inner_ - outer * inverse_outer_ + slope_ * distance - offset_;
        const double inside = distance < range_ ? 1.0 : 0.0;  // the two terms cancel at rc only to rounding
        return {inside * energy, inside * ((inner - outer) * inverse - slope_) * inverse};
    }

  private:
    // With g = rc/r0, the minimum stays at r0 because beta rescales r0, and at −E0 because alpha rescales E0
    // (Clarke, Smith and Woodcock 1986; the form of the DL_POLY manual).
    explicit NMShifted(const Parameters& given)
        : minimum_(given.positive(3)), range_(given.positive(4)), inner_(given.any(1)), outer_(given.positive(2)) {
        const double n = given.any(1);
        const double m = given.any(2);
        given.require(n > m, 1, "greater than m");
        given.require(range_ > minimum_, 4, "greater than r0");
        const double g = range_ / minimum_;
        const double beta = g * std::pow((std::pow(g, m + 1.0) - 1.0) / (std::pow(g, n + 1.0) - 1.0), 1.0 / (n - m));
        const double inner_beta = std::pow(beta, n);
        const double outer_beta = std::pow(beta, m);
        const double alpha = (m - n) / (m * inner_beta * (1.0 + (n / g - n - 1.0) / std::pow(g, n)) -
                                        n * outer_beta * (1.0 + (m / g - m - 1.0) / std::pow(g, m)));
        // Each term is kept as r dU/dr gives it, n m beta^n (r0/r)^n; the energy divides by the exponent again.
        const double strength = alpha * given.any(0) / (n - m) * n * m;
        inner_strength_ = strength * inner_beta;
        outer_strength_ = strength * outer_beta;
        inverse_inner_ = 1.0 / n;
        inverse_outer_ = 1.0 / m;
        const double inner_end = inner_strength_ / std::pow(g, n);
        const double outer_end = outer_strength_ / std::pow(g, m);
        slope_ = (inner_end - outer_end) / range_;
        offset_ = inner_end * inverse_inner_ - outer_end * inverse_outer_ + slope_ * range_;
    }

    double minimum_, range_;
    Power inner_, outer_;
    double inner_strength_, outer_strength_, inverse_inner_, inverse_outer_, slope_, offset_;
};

}  // namespace dlpoly::pair
