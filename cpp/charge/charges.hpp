// The charged beads of a scene: which they are, their charges, and which of them never move.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dlpoly::charge {

// Charges are times the root of the strength: the energy of two of them is their product times u(r).
struct Charges {
    std::vector<std::uint32_t> beads;  // ids, ascending
    std::vector<double> charge;
    std::vector<std::uint8_t> frozen;

    [[nodiscard]] std::size_t size() const noexcept { return beads.size(); }
};

}  // namespace dlpoly::charge
