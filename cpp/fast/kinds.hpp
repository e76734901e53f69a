// What the fast path must know of a scene before it takes it: the kinds of its beads, the momenta they can have, and
// how many candidates its blocks of cells hold.
#pragma once

#include <cstdint>
#include <vector>

#include "core/particles.hpp"
#include "fast/arguments.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly::fast {

// The kinds of beads in a state: species, split where some of its beads are frozen or have another mass.
struct Kinds {
    struct Kind {
        std::int32_t species;
        double mass;
        bool frozen;
    };
    std::vector<Kind> list;
    std::vector<std::uint8_t> of_bead;
};

// No kinds where there are more than `most`.
Kinds find_kinds(const Particles& particles, std::size_t most);

// The largest momentum that fixed-point numbers can hold, chosen far above what the scene can give a bead: 40 times the
// momentum of the heaviest mobile bead at thermal energy, or at the energy of overlapping beads in a random start.
double momentum_range(const Kinds& kinds, const PairTable& table, double thermal_energy);

// Mean number of candidates of a block of cells. Up to the usual number, blocks beyond the buffers are rare in a fluid.
double candidates_of_block(double cells, double beads_a_cell);
inline constexpr double usual_candidates = 0.85 * most_candidates;

}  // namespace dlpoly::fast
