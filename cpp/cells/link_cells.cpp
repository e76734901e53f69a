// Link cells (see link_cells.hpp).
#include "cells/link_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dlpoly {

namespace {

constexpr std::size_t index(int axis) { return static_cast<std::size_t>(axis); }

// Cells wider than the range by this factor keep rounding in the fractional coordinates from losing a pair.
constexpr double rounding_margin = 1.0 + 1e-9;

}  // namespace

void LinkCells::build(const Box& box, const Array3N& position, double range, double minimum_width, double image_range) {
    choose_counts(box, position, range, minimum_width, image_range > 0.0 ? image_range : range);
    sort(box, position);
    if (count_ != grouped_count_ || reach_ != grouped_reach_) {
        group_rows();
        grouped_count_ = count_;
        grouped_reach_ = reach_;
    }
}

void LinkCells::choose_counts(const Box& box, const Array3N& position, double range, double minimum_width,
                              double image_range) {
    periodic_ = box.periodic();
    low_ = Vector3::Constant(-0.5);
    span_ = Vector3::Ones();
    for (int axis = 0; axis < 3; ++axis) {
        if (!periodic_[index(axis)]) {
            double lowest = 0.0;
            double highest = 0.0;
            for (Eigen::Index i = 0; i < position.rows(); ++i) {
                const double s = box.fractional(position.row(i).transpose())[axis];
                lowest = i == 0 ? s : std::min(lowest, s);
                highest = i == 0 ? s : std::max(highest, s);
            }
            low_[axis] = lowest;
            span_[axis] = std::max(highest - lowest, 1e-12);
        }
    }
    const double width = (minimum_width > 0.0 ? minimum_width : range) * rounding_margin;
    Vector3 wanted;
    for (int axis = 0; axis < 3; ++axis) {
        wanted[axis] = std::max(1.0, std::floor(box.widths()[axis] * span_[axis] / width));
    }
    // More cells than a few a bead cost time and memory without shortening any search: thin gases get wider cells.
    const double most = std::max(64.0, 4.0 * static_cast<double>(position.rows()));
    while (wanted.prod() > most) {
        int longest = 0;
        wanted.maxCoeff(&longest);
        wanted[longest] = std::max(1.0, std::floor(0.5 * wanted[longest]));
    }
    several_images_ = false;
    for (int axis = 0; axis < 3; ++axis) {
        count_[index(axis)] = static_cast<std::int32_t>(wanted[axis]);
        const double cell_width = box.widths()[axis] * span_[axis] / wanted[axis];
        const double cells = std::ceil(range * rounding_margin / cell_width);
        reach_[index(axis)] = periodic_[index(axis)] ? static_cast<std::int32_t>(cells)
                                                     : static_cast<std::int32_t>(std::min(cells, wanted[axis] - 1.0));
        several_images_ =
            several_images_ || (periodic_[index(axis)] && box.widths()[axis] < 2.0 * image_range * rounding_margin);
    }
    half_stencil_.clear();
    for (std::int32_t z = 0; z <= reach_[2]; ++z) {
        for (std::int32_t y = z > 0 ? -reach_[1] : 0; y <= reach_[1]; ++y) {
            for (std::int32_t x = z > 0 || y > 0 ? -reach_[0] : 1; x <= reach_[0]; ++x) {
                half_stencil_.push_back({x, y, z});
            }
        }
    }
}

void LinkCells::sort(const Box& box, const Array3N& position) {
    const auto beads = static_cast<std::size_t>(position.rows());
    cell_of_.resize(beads);
    start_.assign(static_cast<std::size_t>(cell_count()) + 1, 0);
    for (std::size_t i = 0; i < beads; ++i) {
        const Vector3 s = box.fractional(position.row(static_cast<Eigen::Index>(i)).transpose());
        std::array<std::int32_t, 3> c{};
        for (int axis = 0; axis < 3; ++axis) {
            const double scaled = (s[axis] - low_[axis]) / span_[axis] * count_[index(axis)];
            c[index(axis)] = std::clamp(static_cast<std::int32_t>(scaled), 0, count_[index(axis)] - 1);
        }
        cell_of_[i] = (c[2] * count_[1] + c[1]) * count_[0] + c[0];
        ++start_[static_cast<std::size_t>(cell_of_[i]) + 1];
    }
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    order_.resize(beads);
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < beads; ++i) {
        order_[next[static_cast<std::size_t>(cell_of_[i])]++] = static_cast<std::uint32_t>(i);
    }
}

void LinkCells::neighbours(std::int32_t cell, std::vector<CellImage>& result) const {
    result.clear();
    const std::array<std::int32_t, 3> c{cell % count_[0], cell / count_[0] % count_[1], cell / (count_[0] * count_[1])};
    for (const auto& offset : half_stencil_) {
        CellImage image{};
        std::array<std::int32_t, 3> target{};
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int32_t absolute = c[axis] + offset[axis];
            const std::int32_t cells = count_[axis];
            image.shift[axis] = absolute >= 0 ? absolute / cells : -((cells - 1 - absolute) / cells);
            target[axis] = absolute - image.shift[axis] * cells;
            inside = inside && (periodic_[axis] || image.shift[axis] == 0);
        }
        if (inside) {
            image.cell = (target[2] * count_[1] + target[1]) * count_[0] + target[0];
            result.push_back(image);
        }
    }
}

std::array<std::int32_t, 3> LinkCells::most_shifts() const noexcept {
    std::array<std::int32_t, 3> most{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        most[axis] = periodic_[axis] ? (reach_[axis] + count_[axis] - 1) / count_[axis] : 0;
    }
    return most;
}

// A row writes to every row its half stencil reaches; rows that reach a common row get different groups.
void LinkCells::group_rows() {
    const std::int32_t rows = count_[1] * count_[2];
    std::vector<std::vector<std::int32_t>> reached(static_cast<std::size_t>(rows));
    std::vector<std::vector<std::int32_t>> reached_by(static_cast<std::size_t>(rows));
    for (std::int32_t row = 0; row < rows; ++row) {
        auto& list = reached[static_cast<std::size_t>(row)];
        list.push_back(row);
        for (const auto& offset : half_stencil_) {
            std::int32_t y = (row % count_[1] + offset[1]) % count_[1];
            std::int32_t z = (row / count_[1] + offset[2]) % count_[2];
            y += y < 0 ? count_[1] : 0;
            z += z < 0 ? count_[2] : 0;
            list.push_back(z * count_[1] + y);
        }
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        for (const std::int32_t target : list) {
            reached_by[static_cast<std::size_t>(target)].push_back(row);
        }
    }
    row_groups_.clear();
    std::vector<std::int32_t> group_of(static_cast<std::size_t>(rows), -1);
    std::vector<std::uint8_t> taken;
    for (std::int32_t row = 0; row < rows; ++row) {
        taken.assign(row_groups_.size() + 1, 0);
        for (const std::int32_t target : reached[static_cast<std::size_t>(row)]) {
            for (const std::int32_t other : reached_by[static_cast<std::size_t>(target)]) {
                const std::int32_t group = group_of[static_cast<std::size_t>(other)];
                if (group >= 0) {
                    taken[static_cast<std::size_t>(group)] = 1;
                }
            }
        }
        const auto free = static_cast<std::size_t>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
        if (free == row_groups_.size()) {
            row_groups_.emplace_back();
        }
        row_groups_[free].push_back(row);
        group_of[static_cast<std::size_t>(row)] = static_cast<std::int32_t>(free);
    }
}

}  // namespace dlpoly
