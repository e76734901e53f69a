// The lattice vectors by which a bead and its neighbour may lie apart, numbered so that numbers add as the vectors do.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/box.hpp"
#include "forces/pair_phases.hpp"

namespace dlpoly {

struct LatticeShifts {
    std::array<std::int64_t, 3> stride{};  // number of a vector: zero + Σ cells along an axis · stride
    std::int64_t zero = 0;
    std::vector<ShiftRecord> vectors;
    std::vector<ImageCodes> codes;  // by number; empty where pairs have one image only

    // Numbers all vectors of up to `reach` cells along each axis.
    void number(const Box& box, const std::array<std::int32_t, 3>& reach, bool several_images);
};

}  // namespace dlpoly
