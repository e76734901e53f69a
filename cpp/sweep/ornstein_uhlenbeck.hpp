// The exact solution of a pair's drag and noise over any time: u' = c u + √(k_B T/μ (1 − c²)) ζ, c = exp(−γ w^D h/μ).
// De Fabritiis, Serrano, Español and Coveney, Physica A 361, 429 (2006); Peters, EPL 66, 311 (2004), scheme II.
#pragma once

#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct OrnsteinUhlenbeck {
    static constexpr bool uniform = false;

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        const double x = pair.relaxation();
        // 1 − c² without loss for small x.
        const double variance = -std::expm1(-2.0 * x) * pair.thermal_energy * pair.inverse_mass;
        return {std::exp(-x), std::sqrt(variance) * draw.normal};
    }
};

}  // namespace dlpoly::sweep
