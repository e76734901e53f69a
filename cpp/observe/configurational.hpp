// The configurational temperature, k_B T = ⟨Σ|∇_i U|²⟩/⟨Σ ∇_i² U⟩ over the mobile beads (Rugh, Phys. Rev. Lett. 78, 772
// (1997); Butler, Ayton, Jepps and Evans, J. Chem. Phys. 109, 6519 (1998)). It depends on positions alone and shows the
// error of a timestep that the kinetic temperature hides.
#pragma once

#include "core/state.hpp"
#include "forces/forces.hpp"

namespace dlpoly {

struct Configurational {
    double squared_force = 0.0;  // Σ|∇_i U|²
    double curvature = 0.0;      // Σ ∇_i² U; not a number when it cannot be computed
};

// Of the present positions. The state's forces stay as they are.
Configurational configurational(State& state, Forces& forces);

}  // namespace dlpoly
