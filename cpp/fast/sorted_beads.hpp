// The records of a chunk of steps, in the order of the cells of the grid, and the sorting that brings them there.
//
// Each step reads the records in cell order (`sorted`) and writes them moved (`advanced`), every thread into the places
// of the rows of cells that are its share; a counting sort then brings them back into cell order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "fast/added_forces.hpp"
#include "fast/aligned_array.hpp"
#include "fast/arguments.hpp"
#include "fast/grid.hpp"

namespace dlpoly::fast {

template <class Record>
class SortedBeads {
  public:
    using Fixed = typename Record::Fixed;

    // holds: four numbers of each bead are kept beside it from pass to pass, `held`; holds_next: and from step to step.
    SortedBeads(Grid grid, std::size_t beads, bool holds, bool holds_next);

    [[nodiscard]] const Grid& grid() const noexcept { return grid_; }
    [[nodiscard]] std::size_t count() const noexcept { return beads_; }
    [[nodiscard]] const Record* sorted() const noexcept { return sorted_.data(); }
    [[nodiscard]] const Record* advanced() const noexcept { return advanced_.data(); }
    Record* advanced() noexcept { return advanced_.data(); }
    [[nodiscard]] const Fixed* held() const noexcept { return held_.data(); }  // in the order of sorted
    Fixed* held_next() noexcept { return held_next_.data(); }                  // in the order of advanced

    // Impulses of the last step, 3 a bead by id. They stand where the advanced records of the step before stood: once
    // those have been sorted, a last step neither reads nor writes any.
    std::int64_t* impulses() noexcept {
        static_assert(3 * sizeof(std::int64_t) <= sizeof(Record));
        return reinterpret_cast<std::int64_t*>(advanced_.data());
    }

    // Forgets the shares of threads: all beads are about to be written to `advanced` by one. Returns the histogram in
    // which their cells are to be counted.
    std::vector<std::int32_t>& restart();

    // Tells a pass where the records and the cells are; refresh: after `exchange`.
    void describe(PassArguments<Record>& a);
    void refresh(PassArguments<Record>& a);

    // Brings the advanced beads into the order of the cells. Called by all threads together. placed: takes note of the
    // positions of the beads that have other forces than those of the passes; nullptr when none are due.
    void sort(std::size_t part, std::size_t parts, AddedForces<Record>* placed);

    // The rows of cells that a thread handles; also where it writes what it advances.
    std::pair<std::int32_t, std::int32_t> share(PassArguments<Record>& a, std::size_t part, std::size_t parts);

    // Puts the beads of each cell of some rows into the order of their ids. Forces do not depend on the order, but the
    // sums of an observed step are floating-point ones: with one order they are the same to the bit however a run was
    // cut into chunks.
    void order_cells(std::int32_t begin, std::int32_t end);

    // The advanced beads have not moved: their places are those of the sorted ones.
    void exchange() noexcept { sorted_.swap(advanced_); }

  private:
    void prefix_sums();
    void sort_part(std::size_t part, AddedForces<Record>* placed);
    void order_held(std::int32_t begin, std::int32_t end);
    [[nodiscard]] std::int32_t first_place(int part, int parts) const;

    void cast_shadow(const Record& bead, std::int32_t place) {
        shadow_x_.data()[place] = static_cast<std::uint8_t>(bead.x >> grid_.shadow_shift[0]);
        shadow_y_.data()[place] = static_cast<std::uint8_t>(bead.y >> grid_.shadow_shift[1]);
        shadow_z_.data()[place] = static_cast<std::uint8_t>(bead.z >> grid_.shadow_shift[2]);
    }

    Grid grid_;
    std::size_t beads_;
    bool holds_next_;
    AlignedArray<Record> sorted_;
    AlignedArray<Record> advanced_;
    AlignedArray<std::uint8_t> shadow_x_;
    AlignedArray<std::uint8_t> shadow_y_;
    AlignedArray<std::uint8_t> shadow_z_;
    AlignedArray<std::int32_t> cell_of_;
    AlignedArray<std::int32_t> row_start_;
    AlignedArray<Fixed> held_;
    AlignedArray<Fixed> held_next_;
    std::vector<std::vector<std::int32_t>> histograms_;
    std::vector<std::int32_t> part_;  // beads part_[t] … part_[t + 1] of `advanced_` belong to thread t
};

}  // namespace dlpoly::fast
