// DL_POLY's order "zeroth": one implicit step, u' = (u + σ w^R √h b ζ/μ)/(1 + g), g = γ w^D h/μ. DL_POLY takes
// b = 1 + ½g, which makes a pair too hot by that factor; b = √(1 + ½g) keeps its variance k_B T/μ.
#pragma once

#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct ImplicitEuler {
    static constexpr bool uniform = false;

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        const double g = pair.relaxation();
        const double variance = g * (2.0 + g) * pair.thermal_energy * pair.inverse_mass;
        return {1.0 / (1.0 + g), std::sqrt(variance) * draw.normal / (1.0 + g)};
    }
};

}  // namespace dlpoly::sweep
