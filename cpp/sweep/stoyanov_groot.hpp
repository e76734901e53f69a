// Stoyanov and Groot, J. Chem. Phys. 122, 114112 (2005): pairs are thermalised as by Lowe with the probability Γh; the
// others feel −α w (1 − T₀/T_pair) u, which drives the temperature of the pairs, T_pair = Σ w μ u²/Σ w, to T₀.
#pragma once

#include <cmath>

#include "sweep/lowe_andersen.hpp"
#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct StoyanovGroot {
    static constexpr bool uniform = true;

    double coupling = 0.0;  // α (1 − T₀/T_pair), Da/ps

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        if (LoweAndersen::chosen(pair, draw)) {
            return LoweAndersen()(pair, draw);
        }
        // w, not w^D; the exact decay, so that no α turns a velocity around.
        const double w = std::sqrt(pair.weight);
        return {std::exp(-coupling * w * pair.duration * pair.inverse_mass), 0.0};
    }
};

}  // namespace dlpoly::sweep
