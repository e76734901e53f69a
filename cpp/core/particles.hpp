// The beads as a structure of arrays in file order: a bead's id is its index.
#pragma once

#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace dlpoly {

struct Particles {
    Array3N position;  // wrapped, Å
    Array3N velocity;  // Å/ps
    Array3N force;     // Da Å/ps²
    Image3N image;     // cells crossed since the start
    std::vector<double> mass;
    std::vector<std::int32_t> species;
    std::vector<std::uint8_t> frozen;
    // What beads carry, in scenes that model it; else empty.
    std::vector<double> temperature;    // internal, as k_B T
    std::vector<double> heat_capacity;  // C_v/k_B: the internal energy is their product
    ArrayXN concentration;              // of dissolved species, (beads, species)

    [[nodiscard]] Eigen::Index count() const noexcept { return position.rows(); }

    // 0 for frozen beads: they never move.
    [[nodiscard]] double inverse_mass(Eigen::Index bead) const noexcept {
        const auto i = static_cast<std::size_t>(bead);
        return frozen[i] != 0 ? 0.0 : 1.0 / mass[i];
    }
};

}  // namespace dlpoly
