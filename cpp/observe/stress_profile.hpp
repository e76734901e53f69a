// The stress of one configuration in layers of equal thickness along an axis of the cell.
//
// A pair's F_a r_b is shared out among the layers by the length of the straight line between its beads that lies in
// each (Irving and Kirkwood, J. Chem. Phys. 18, 817 (1950)); m v_a v_b belongs to the layer of the bead. The forces of
// a bonded term of n beads are taken as the pair forces F_ij = (F_i − F_j)/n (Goetz and Lipowsky, J. Chem. Phys. 108,
// 7397 (1998)), which is the force itself for a bond. The layers add up to the stress of the whole cell.
#pragma once

#include <cstdint>
#include <vector>

#include "core/state.hpp"
#include "forces/forces.hpp"

namespace dlpoly {

// Per layer the components xx yy zz xy xz yz of Σ m v_a v_b and Σ F_a r_b, off the diagonal the mean of ab and ba.
struct StressProfile {
    std::vector<double> kinetic;
    std::vector<double> conservative;  // pairs, with scaled 1-4 pairs
    std::vector<double> bonded;
    std::vector<std::int64_t> beads;  // [layer · species + s], frozen ones too
};

// Of the present positions and velocities; forces on beads stay as they are. The cell must be periodic along the axis,
// and its vector along it perpendicular to the other two. Throws std::invalid_argument where it is not, RunFailure
// where a force is not finite.
StressProfile stress_profile(const State& state, Forces& forces, int axis, std::int32_t layers);

}  // namespace dlpoly
