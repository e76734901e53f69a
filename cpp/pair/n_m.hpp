// Pair law nm: Mie potential, U = E0/(n − m) [m (r0/r)^n − n (r0/r)^m].
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class NM {
    static constexpr std::array<std::string_view, 4> names{"E0", "n", "m", "r0"};

  public:
    static constexpr LawInfo info{.key = "nm",
                                  .description = "n-m (Mie), E0/(n-m) [m (r0/r)^n - n (r0/r)^m]",
                                  .parameter_names = names,
                                  .energy_mask = 0b0001,
                                  .drag_slot = 5,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    // n and m are real numbers; DL_POLY truncates them to whole ones without a word.
    NM(std::span<const double> parameters, double cutoff) : NM(Parameters(info, parameters, cutoff)) {}

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double ratio = minimum_ / std::sqrt(distance_squared);
        const double inner = inner_(ratio);
        const double outer = outer_(ratio);
        return {strength_ * (outer_.exponent() * inner - inner_.exponent() * outer),
                force_strength_ * (inner - outer) / distance_squared};
    }

  private:
    explicit NM(const Parameters& given)
        : minimum_(given.positive(3)), inner_(given.any(1)), outer_(given.positive(2)) {
        given.require(given.any(1) > given.any(2), 1, "greater than m");
        strength_ = given.any(0) / (given.any(1) - given.any(2));
        force_strength_ = strength_ * given.any(1) * given.any(2);
    }

    double strength_, force_strength_, minimum_;
    Power inner_, outer_;
};

}  // namespace dlpoly::pair
