// Link cells: beads sorted into a grid over the cell, and the half stencil of neighbouring cells.
//
// Cell offsets are counted without wrapping, and the whole cells by which an offset leaves the box become the shift of
// the image. Each (bead, bead, image) closer than the range is therefore met exactly once for any number of cells an
// axis, one cell included: boxes smaller than the range need no special case.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/box.hpp"
#include "core/types.hpp"

namespace dlpoly {

// A neighbouring cell met from some cell: its index and the lattice vector to add to positions in it.
struct CellImage {
    std::int32_t cell;
    std::array<std::int32_t, 3> shift;
};

class LinkCells {
  public:
    // Grids the box for pairs closer than `range`; cells are at least `minimum_width` wide if that is larger than 0,
    // and at least range wide otherwise. Beads far outside along open axes only enlarge the grid's cells. Whether two
    // beads have several images is asked for `image_range`, or for the range where that is 0.
    void build(const Box& box, const Array3N& position, double range, double minimum_width = 0.0,
               double image_range = 0.0);

    [[nodiscard]] std::int32_t cell_count() const noexcept { return count_[0] * count_[1] * count_[2]; }
    [[nodiscard]] const std::array<std::int32_t, 3>& counts() const noexcept { return count_; }

    // Sorted order: bead ids grouped by cell, ascending inside a cell; beads of cell c are order()[start(c) ..
    // start(c+1)).
    [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return order_; }
    [[nodiscard]] std::uint32_t start(std::int32_t cell) const noexcept {
        return start_[static_cast<std::size_t>(cell)];
    }

    // The upper half of the neighbours of a cell, without the cell itself in place.
    void neighbours(std::int32_t cell, std::vector<CellImage>& result) const;

    // The largest shift along each axis that a neighbour can have.
    [[nodiscard]] std::array<std::int32_t, 3> most_shifts() const noexcept;

    // Rows of cells along the first axis, grouped so that rows of one group share no cell that they read or write.
    [[nodiscard]] const std::vector<std::vector<std::int32_t>>& row_groups() const noexcept { return row_groups_; }
    [[nodiscard]] std::int32_t row_length() const noexcept { return count_[0]; }

    // True when two beads can meet in more than one image within the image range.
    [[nodiscard]] bool has_several_images() const noexcept { return several_images_; }

  private:
    void choose_counts(const Box& box, const Array3N& position, double range, double minimum_width, double image_range);
    void sort(const Box& box, const Array3N& position);
    void group_rows();

    std::array<std::int32_t, 3> count_{1, 1, 1};
    std::array<std::int32_t, 3> reach_{1, 1, 1};
    std::array<bool, 3> periodic_{true, true, true};
    Vector3 low_ = Vector3::Constant(-0.5);  // fractional coordinate of the grid's lower corner
    Vector3 span_ = Vector3::Ones();
    bool several_images_ = false;
    std::vector<std::array<std::int32_t, 3>> half_stencil_;
    std::vector<std::uint32_t> start_;
    std::vector<std::uint32_t> order_;
    std::vector<std::int32_t> cell_of_;
    std::vector<std::vector<std::int32_t>> row_groups_;
    std::array<std::int32_t, 3> grouped_count_{0, 0, 0};
    std::array<std::int32_t, 3> grouped_reach_{0, 0, 0};
};

}  // namespace dlpoly
