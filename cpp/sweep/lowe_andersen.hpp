// Lowe's thermostat, Europhys. Lett. 47, 145 (1999): with the probability Γh a pair closer than its range gets a new
// relative velocity from the Maxwell distribution, at any distance alike. Γ = ½γ/μ, which is γ/m for equal masses, so
// that FIELD's drags serve as rates.
#pragma once

#include <cmath>

#include "sweep/pair_map.hpp"

namespace dlpoly::sweep {

struct LoweAndersen {
    static constexpr bool uniform = true;

    [[nodiscard]] static bool chosen(const PairSituation& pair, const PairDraw& draw) noexcept {
        return draw.uniform < 0.5 * pair.drag * pair.inverse_mass * pair.duration;
    }

    LinearMap operator()(const PairSituation& pair, const PairDraw& draw) const noexcept {
        if (!chosen(pair, draw)) {
            return {};
        }
        return {0.0, std::sqrt(pair.thermal_energy * pair.inverse_mass) * draw.normal};
    }
};

}  // namespace dlpoly::sweep
