// Lees–Edwards boundaries (J. Phys. C 5, 1921 (1972)): images along y move along x with the velocity rate · L_y of the
// flow u_x = rate · y. The cell is a triclinic one whose second vector (offset, L_y, 0) tilts with time; its offset is
// kept in [−½L_x, ½L_x] by whole edges, so that it is part of the state and needs no clock.
#pragma once

#include "core/state.hpp"

namespace dlpoly {

// Lets the images move for this time. Images of beads are counted anew where the offset jumps by an edge, so that
// unwrapped positions go on as before.
void tilt(State& state, double rate, double time);

}  // namespace dlpoly
