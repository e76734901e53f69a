// The Langevin piston: edges of the cell that follow the pressure (Quigley and Probert, J. Chem. Phys. 120, 11432
// (2004); equations of motion of Martyna, Tobias and Klein, J. Chem. Phys. 101, 4177 (1994)).
//
// η_a = d ln L_a/dt is the rate of edge a; edges that move by one factor share one. With g degrees of freedom, the mass
// W = g k_B T τ² (a third of it for each edge), P the pressure of conservative forces and velocities, P₀ the target:
//
//   dr_a/dt = v_a + η_a r_a          dv_a/dt = F_a/m − (η_a + Σ_b η_b/g) v_a
//   ⅓W dη_a/dt = V (P_aa − P₀_a) + Σ m v²/g − γ ⅓W η_a + √(2γ k_B T W/3) noise        (sums over the edges that share
//   η)
//
// Momentum stays 0. The piston's part with the virial and P₀V is taken at the ends of a step, with the velocities' part
// beside it where velocities of whole steps are the ones reported, and else in the middle; friction and noise are exact
// and in the middle.
#pragma once

#include "core/state.hpp"
#include "forces/forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly {

// Makes room for the rates in State::thermostat.
void start_piston(State& state, const StepSettings& settings);

// What the forces of the present positions do to the rates in `time`. Needs totals that were observed. This and the
// next two do nothing where the cell is fixed.
void push_piston(State& state, const Forces& forces, const PairTotals& totals, const StepSettings& settings,
                 double time);

// In the middle of the drift, before and after what a thermostat does there.
void enter_middle(State& state, const StepSettings& settings);
void leave_middle(State& state, const StepSettings& settings);

// Σ ½W_a η_a² + P₀V − tension · area; 0 where the cell is fixed.
double barostat_energy(const State& state, const StepSettings& settings);

}  // namespace dlpoly
