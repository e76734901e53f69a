// The pairs' part of the pairwise Nosé–Hoover–Langevin thermostat: a drag ζ w^D that all pairs share and that may be
// negative, u' = u exp(−ζ w^D h/μ). Leimkuhler and Shang, arXiv:1405.4839 (2015).
#pragma once

#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct CommonDrag {
    static constexpr bool uniform = false;

    double drag = 0.0;  // ζ, Da/ps

    LinearMap operator()(const PairSituation& pair, const PairDraw&) const noexcept {
        return {std::exp(-drag * pair.weight * pair.duration * pair.inverse_mass), 0.0};
    }
};

}  // namespace dlpoly::sweep
