// Peters' scheme I, EPL 66, 311 (2004): u' = (1 − A) u + √(k_B T/μ A(2 − A)) ζ with A = γ w^D h/μ, which needs A < 2.
#pragma once

#include <algorithm>
#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct PetersFirst {
    static constexpr bool uniform = false;

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        // Whether A can reach 2 is checked before the run; at contact it may by rounding.
        const double a = std::min(pair.relaxation(), 2.0);
        return {1.0 - a, std::sqrt(a * (2.0 - a) * pair.thermal_energy * pair.inverse_mass) * draw.normal};
    }
};

}  // namespace dlpoly::sweep
