// What changes while a simulation runs: the cell, the beads, the step and the time.
#pragma once

#include <cstdint>

#include "core/box.hpp"
#include "core/particles.hpp"

namespace dlpoly {

struct State {
    Box box;
    Particles particles;
    std::uint64_t step = 0;
    double time = 0.0;  // ps
};

}  // namespace dlpoly
