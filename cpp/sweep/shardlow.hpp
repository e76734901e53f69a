// Shardlow's map, SIAM J. Sci. Comput. 24, 1267 (2003): half a step explicitly, half implicitly, with one ζ:
// u₁ = (1 − g) u + s, u' = (u₁ + s)/(1 + g) with g = ½γ w^D h/μ and s = ½σ w^R √h ζ/μ. The variance k_B T/μ is kept for
// every h.
#pragma once

#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct Shardlow {
    static constexpr bool uniform = false;

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        const double g = 0.5 * pair.relaxation();
        const double twice_s = std::sqrt(4.0 * g * pair.thermal_energy * pair.inverse_mass) * draw.normal;
        return {(1.0 - g) / (1.0 + g), twice_s / (1.0 + g)};
    }
};

}  // namespace dlpoly::sweep
