// Lees–Edwards boundaries (see shear.hpp).
#include "integrate/shear.hpp"

#include <cmath>

namespace dlpoly {

void tilt(State& state, double rate, double time) {
    Matrix3 cell = state.box.cell();
    double offset = cell(1, 0) + rate * cell(1, 1) * time;
    const double edges = std::nearbyint(offset / cell(0, 0));
    if (edges != 0.0) {
        offset -= edges * cell(0, 0);
        Image3N& image = state.particles.image;
        image.col(0) += static_cast<std::int32_t>(edges) * image.col(1);
    }
    cell(1, 0) = offset;
    state.box = Box(cell, state.box.periodic());
}

}  // namespace dlpoly
