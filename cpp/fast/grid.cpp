// The cells of the fast path (see grid.hpp).
#include "fast/grid.hpp"

#include <algorithm>
#include <cmath>

namespace dlpoly::fast {

namespace {

// Rows in tiles, so that the rows a row needs were used shortly before and are still in the cache.
void order_rows(Grid& grid) {
    constexpr std::int32_t tile = 8;
    const std::int32_t rows_y = grid.counts[1];
    const std::int32_t rows_z = grid.counts[2];
    grid.row_at.clear();
    for (std::int32_t tile_z = 0; tile_z < rows_z; tile_z += tile) {
        for (std::int32_t tile_y = 0; tile_y < rows_y; tile_y += tile) {
            for (std::int32_t z = tile_z; z < std::min(rows_z, tile_z + tile); ++z) {
                for (std::int32_t y = tile_y; y < std::min(rows_y, tile_y + tile); ++y) {
                    grid.row_at.push_back(z * rows_y + y);
                }
            }
        }
    }
    grid.row_rank.resize(grid.row_at.size());
    for (std::size_t place = 0; place < grid.row_at.size(); ++place) {
        grid.row_rank[static_cast<std::size_t>(grid.row_at[place])] = static_cast<std::int32_t>(place);
    }
}

}  // namespace

Grid make_grid(const Vector3& edges, double range, double cell_width, int position_size) {
    // Sums of three entries up to this mean "may be in range"; entries are in units of range²/scale.
    constexpr double scale = 200.0;
    Grid grid{};
    grid.threshold = static_cast<std::uint8_t>(scale);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double edge = edges[static_cast<Eigen::Index>(axis)];
        grid.counts[axis] = std::max(4, static_cast<std::int32_t>(std::floor(edge / cell_width)));
        const double cell = edge / grid.counts[axis];
        // Shadows repeat after edge/2^m. Candidates are less than three cells away; where shadows repeat after four or
        // more, a shadow distance that is one repeat off is still more than one cell, which no pair in range has.
        int m = 0;
        while (edge / (1 << (m + 1)) >= 4.0 * cell) {
            ++m;
        }
        grid.shadow_shift[axis] = position_size - 8 - m;
        const double resolution = edge / (1 << m) / 256.0;
        for (int k = 0; k < 128; ++k) {
            // Shadows k apart belong to coordinates at least k − 1 resolutions apart.
            const double distance = std::max(k - 1, 0) * resolution / range;
            grid.distance[axis][static_cast<std::size_t>(k)] =
                static_cast<std::uint8_t>(std::min(255.0, std::floor(distance * distance * scale)));
        }
    }
    order_rows(grid);
    return grid;
}

}  // namespace dlpoly::fast
