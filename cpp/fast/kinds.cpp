// Kinds of beads and their ranges (see kinds.hpp).
#include "fast/kinds.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dlpoly::fast {

Kinds find_kinds(const Particles& particles, std::size_t most) {
    Kinds kinds;
    kinds.of_bead.resize(static_cast<std::size_t>(particles.count()));
    for (std::size_t i = 0; i < kinds.of_bead.size(); ++i) {
        const bool frozen = particles.frozen[i] != 0;
        std::size_t k = 0;
        while (k < kinds.list.size() &&
               !(kinds.list[k].species == particles.species[i] && kinds.list[k].frozen == frozen &&
                 (frozen || kinds.list[k].mass == particles.mass[i]))) {
            ++k;
        }
        if (k == kinds.list.size()) {
            if (k == most) {
                kinds.list.clear();
                return kinds;
            }
            kinds.list.push_back({particles.species[i], particles.mass[i], frozen});
        }
        kinds.of_bead[i] = static_cast<std::uint8_t>(k);
    }
    return kinds;
}

double momentum_range(const Kinds& kinds, const PairTable& table, double thermal_energy) {
    double heaviest = 0.0;
    for (const Kinds::Kind& kind : kinds.list) {
        heaviest = kind.frozen ? heaviest : std::max(heaviest, kind.mass);
    }
    double energy = thermal_energy;
    for (const PairTable::SoftLaw& law : table.soft_laws()) {
        energy = std::max(energy, 0.2 * std::abs(law.repulsion) * law.cutoff);
    }
    return 40.0 * std::sqrt(heaviest * energy);
}

double candidates_of_block(double cells, double beads_a_cell) { return 9.0 * (cells + 2.0) * beads_a_cell; }

}  // namespace dlpoly::fast
