// The cells of the fast path: how many, in which order their rows lie in memory, and the tables of the 8-bit search.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace dlpoly::fast {

struct Grid {
    std::array<std::int32_t, 3> counts;  // cells along each edge, at least four
    std::vector<std::int32_t> row_rank;  // place in memory of row (z · rows_y + y)
    std::vector<std::int32_t> row_at;    // row at each place
    std::array<int, 3> shadow_shift;     // the shadow of a coordinate is its bits from here on, 8 of them
    std::array<std::array<std::uint8_t, 128>, 3> distance;  // squared shadow distance, rounded down
    std::uint8_t threshold;

    [[nodiscard]] std::int32_t rows() const noexcept { return counts[1] * counts[2]; }
    [[nodiscard]] std::int32_t cells() const noexcept { return counts[0] * rows(); }
};

// range: of the longest pair; cell_width: at least that. position_size: bits of a fixed-point position's integer type.
Grid make_grid(const Vector3& edges, double range, double cell_width, int position_size);

}  // namespace dlpoly::fast
