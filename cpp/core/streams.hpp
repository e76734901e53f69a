// Every stream of random numbers, one line each. Numbers are never reused or renumbered once released.
#pragma once

#include <cstdint>

namespace dlpoly {

enum class Stream : std::uint8_t {
    pair_noise = 1,        // ζ_ij of the DPD random force
    start_velocities = 2,  // Maxwell velocities of a clean start
    regauss = 3,           // Maxwell velocities redrawn during equilibration
    bead_words = 4,        // keys of the beads' random words, from which pair noise is mixed
    sweep_words = 5,       // the same for sweeps over pairs; a step's second sweep has the next number
    second_sweep = 6,
    sweep_choice = 7,    // which pairs a sweep thermalises (Philox for every pair)
    thermostat = 8,      // noise of thermostats that have variables of their own
    barostat = 9,        // noise of the piston that moves the cell
    heat_noise = 10,     // of the heat that neighbours exchange
    species_noise = 11,  // random fluxes of dissolved species
    constraints = 20,    // velocities along fixed distances that pairs are thermalised with
};

}  // namespace dlpoly
