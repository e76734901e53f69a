// What changes while a simulation runs: the cell, the beads, the step and the time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/box.hpp"
#include "core/particles.hpp"

namespace dlpoly {

struct State {
    Box box;
    Particles particles;
    std::uint64_t step = 0;
    double time = 0.0;  // ps
    // Variables that a thermostat keeps from step to step, or a barostat: the rates d ln L/dt of the edges, 1/ps.
    std::vector<double> thermostat;
    // Of beads that carry heat: what sources and beads of held temperature gave since the start; and what the internal
    // energies have already been charged for work of drag and noise that the next half kick does.
    double heat_supplied = 0.0;
    double heat_ahead = 0.0;
};

}  // namespace dlpoly
