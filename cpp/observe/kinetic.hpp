// Kinetic quantities of the beads that can move. With a shear rate, velocities are those relative to the flow
// u_x = rate · y.
#pragma once

#include "core/particles.hpp"

namespace dlpoly {

// Σ m v_a v_b, Da Å²/ps²; its trace is twice the kinetic energy.
Matrix3 kinetic_tensor(const Particles& particles, double shear_rate = 0.0);

// Σ m v, Da Å/ps.
Vector3 momentum(const Particles& particles, double shear_rate = 0.0);

// Mass of the beads that are not frozen.
double mobile_mass(const Particles& particles);

// Takes the centre-of-mass velocity from every mobile bead.
void remove_drift(Particles& particles, double shear_rate = 0.0);

}  // namespace dlpoly
