// Sorting by cells (see sorted_beads.hpp).
#include "fast/sorted_beads.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#define DLPOLY_SIMD plain
#include "fast/scalar.hpp"

namespace dlpoly::fast {

template <class Record>
SortedBeads<Record>::SortedBeads(Grid grid, std::size_t beads, bool holds, bool holds_next)
    : grid_(std::move(grid)),
      beads_(beads),
      holds_next_(holds_next),
      sorted_(beads_ + padding),
      advanced_(beads_ + padding),
      shadow_x_(beads_ + padding),
      shadow_y_(beads_ + padding),
      shadow_z_(beads_ + padding),
      cell_of_(std::is_same_v<Record, MixedRecord> ? beads_ : 0),
      row_start_(static_cast<std::size_t>(grid_.cells()) + 1),
      held_(holds ? 4 * beads_ : 0),
      held_next_(holds_next ? 4 * beads_ : 0) {}

template <class Record>
std::vector<std::int32_t>& SortedBeads<Record>::restart() {
    histograms_.assign(1, std::vector<std::int32_t>(static_cast<std::size_t>(grid_.cells()), 0));
    part_ = {0, static_cast<std::int32_t>(beads_)};
    return histograms_.front();
}

template <class Record>
void SortedBeads<Record>::describe(PassArguments<Record>& a) {
    refresh(a);
    a.shadow_x = shadow_x_.data();
    a.shadow_y = shadow_y_.data();
    a.shadow_z = shadow_z_.data();
    a.row_start = row_start_.data();
    a.row_rank = grid_.row_rank.data();
    a.row_at = grid_.row_at.data();
    a.cells_x = grid_.counts[0];
    a.rows_y = grid_.counts[1];
    a.rows_z = grid_.counts[2];
    a.distance_x = grid_.distance[0].data();
    a.distance_y = grid_.distance[1].data();
    a.distance_z = grid_.distance[2].data();
    a.threshold = grid_.threshold;
    a.cell_of = cell_of_.data();
    a.held = held_.data();
    a.held_next = held_next_.data();
}

template <class Record>
void SortedBeads<Record>::refresh(PassArguments<Record>& a) {
    a.sorted = sorted_.data();
    a.advanced = advanced_.data();
    a.impulses = impulses();
}

// Starts of all cells for every thread's beads: stable in the threads' order, which is that of the beads.
template <class Record>
void SortedBeads<Record>::prefix_sums() {
    std::int32_t* start = row_start_.data();
    std::int32_t sum = 0;
    for (std::size_t cell = 0; cell < static_cast<std::size_t>(grid_.cells()); ++cell) {
        start[cell] = sum;
        for (std::vector<std::int32_t>& histogram : histograms_) {
            const std::int32_t beads = histogram[cell];
            histogram[cell] = sum;
            sum += beads;
        }
    }
    start[grid_.cells()] = sum;
}

template <class Record>
void SortedBeads<Record>::sort_part(std::size_t part, AddedForces<Record>* placed) {
    std::int32_t* next = histograms_[part].data();
    const Record* from = advanced_.data();
    Record* to = sorted_.data();
    for (std::int32_t i = part_[part]; i < part_[part + 1]; ++i) {
        const std::int32_t place = next[plain::kept_cell(cell_of_.data(), from, i)]++;
        to[place] = from[i];
        if (holds_next_) {
            std::copy_n(held_next_.data() + 4 * static_cast<std::size_t>(i), 4,
                        held_.data() + 4 * static_cast<std::size_t>(place));
        }
        cast_shadow(from[i], place);
        if (placed != nullptr) {
            placed->place(from[i]);
        }
    }
}

template <class Record>
void SortedBeads<Record>::sort(std::size_t part, std::size_t parts, AddedForces<Record>* placed) {
#ifdef _OPENMP
#pragma omp single
#endif
    prefix_sums();
    const auto written = histograms_.size();
    for (std::size_t source = part; source < written; source += parts) {
        sort_part(source, placed);
    }
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    {
        histograms_.resize(parts);
        part_.assign(parts + 1, 0);
    }
}

// The place at which a part's rows begin when beads are shared out evenly.
template <class Record>
std::int32_t SortedBeads<Record>::first_place(int part, int parts) const {
    if (part == parts) {
        return grid_.rows();
    }
    const auto target = static_cast<std::int32_t>(static_cast<std::int64_t>(beads_) * part / parts);
    std::int32_t low = 0;
    std::int32_t high = grid_.rows();
    while (low < high) {
        const std::int32_t middle = (low + high) / 2;
        if (row_start_.data()[static_cast<std::int64_t>(middle) * grid_.counts[0]] < target) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

template <class Record>
std::pair<std::int32_t, std::int32_t> SortedBeads<Record>::share(PassArguments<Record>& a, std::size_t part,
                                                                 std::size_t parts) {
    std::vector<std::int32_t>& histogram = histograms_[part];
    histogram.assign(static_cast<std::size_t>(grid_.cells()), 0);
    a.histogram = histogram.data();
    const std::int32_t begin = first_place(static_cast<int>(part), static_cast<int>(parts));
    const std::int32_t end = first_place(static_cast<int>(part) + 1, static_cast<int>(parts));
    part_[part + 1] = row_start_.data()[static_cast<std::int64_t>(end) * grid_.counts[0]];
    return {begin, end};
}

// Puts what is held for the beads of one cell into the order of their ids.
template <class Record>
void SortedBeads<Record>::order_held(std::int32_t begin, std::int32_t end) {
    std::vector<std::pair<std::uint32_t, std::array<Fixed, 4>>> beads;
    for (std::int32_t i = begin; i < end; ++i) {
        std::array<Fixed, 4> held{};
        std::copy_n(held_.data() + 4 * static_cast<std::size_t>(i), 4, held.begin());
        beads.emplace_back(sorted_.data()[i].tag & id_mask, held);
    }
    std::sort(beads.begin(), beads.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::int32_t i = begin; i < end; ++i) {
        const std::array<Fixed, 4>& held = beads[static_cast<std::size_t>(i - begin)].second;
        std::copy_n(held.begin(), 4, held_.data() + 4 * static_cast<std::size_t>(i));
    }
}

template <class Record>
void SortedBeads<Record>::order_cells(std::int32_t begin, std::int32_t end) {
    const std::int32_t* start = row_start_.data();
    for (std::int32_t cell = begin * grid_.counts[0]; cell < end * grid_.counts[0]; ++cell) {
        Record* first = sorted_.data() + start[cell];
        Record* last = sorted_.data() + start[cell + 1];
        if (holds_next_) {
            order_held(start[cell], start[cell + 1]);
        }
        std::sort(first, last, [](const Record& a, const Record& b) { return (a.tag & id_mask) < (b.tag & id_mask); });
        for (std::int32_t i = start[cell]; i < start[cell + 1]; ++i) {
            cast_shadow(sorted_.data()[i], i);
        }
    }
}

template class SortedBeads<MixedRecord>;
template class SortedBeads<DoubleRecord>;

}  // namespace dlpoly::fast
