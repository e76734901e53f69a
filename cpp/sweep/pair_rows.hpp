// The pairs of a sweep, row of cells after row of cells, in an order that follows from the positions alone: colours of
// rows, rows, cells, and ids in the cells. Rows of one colour share no bead, so threads take them in any order, and
// what a sweep makes of its pairs is the same bits for any number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "cells/link_cells.hpp"
#include "core/box.hpp"
#include "core/particles.hpp"
#include "forces/exclusions.hpp"
#include "forces/lattice_shifts.hpp"
#include "forces/pair_phases.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly {

class PairRows {
  public:
    // The pairs of one row of cells that act on each other, in the order of their turn. The arrays may be longer.
    struct Row {
        std::vector<std::uint32_t> i, j;  // in sorted order
        std::vector<std::uint8_t> image;  // tells several images of one pair apart
        std::vector<std::uint32_t> term;  // of the pair table
        std::vector<double> dx, dy, dz, squared;
        std::size_t count = 0;

        [[nodiscard]] std::size_t size() const noexcept { return count; }
        void make_room(std::size_t pairs);
    };

    enum class Frozen : std::uint8_t { skip_pairs, keep_pairs };  // of two frozen beads

    // `reach` by term of the table: pairs closer than this take part, 0 = none. `exclusions` must outlive this.
    PairRows(const PairTable& table, const Exclusions& exclusions, std::vector<double> reach, Frozen frozen);

    // Whether any pair may take part.
    [[nodiscard]] bool any() const noexcept { return range_ > 0.0; }
    [[nodiscard]] static int useful_threads(const Particles& particles);

    // Sorts the beads of the present positions into cells.
    void sort(const Box& box, const Particles& particles, int threads);

    // Ids of beads in sorted order; heights of theirs.
    [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return cells_.order(); }
    [[nodiscard]] const std::vector<double>& y() const noexcept { return y_; }
    // Whether a pair may have several images; else all have the number 0.
    [[nodiscard]] bool has_images() const noexcept { return !lattice_.codes.empty(); }
    // Number of rows of cells; visitors are told which one they see.
    [[nodiscard]] std::size_t count() const {
        return static_cast<std::size_t>(cells_.cell_count() / cells_.row_length());
    }

    // Shows every row, colour after colour; backward: the colours in opposite order (the visitor turns the pairs).
    void visit(bool backward, int threads,
               const std::function<void(const Row&, std::size_t place, std::size_t thread)>& visitor);

  private:
    struct Scratch {
        Row row;
        std::vector<ListEntry> found;
        std::vector<CellImage> neighbours;
        std::vector<CandidateRange> ranges;
    };
    void find_pairs(std::int32_t row, Scratch& scratch) const;
    void find_ranges(std::int32_t cell, Scratch& scratch) const;
    void append(std::uint32_t i, const ListEntry* found, const ListEntry* last, Row& row) const;

    std::int32_t species_count_;
    const Exclusions& exclusions_;
    const Phases* phases_;
    std::vector<double> reach_squared_;  // by term
    double range_ = 0.0;
    bool skip_frozen_;
    LinkCells cells_;
    LatticeShifts lattice_;
    std::vector<double> x_, y_, z_;  // sorted
    std::vector<std::int32_t> species_;
    std::vector<std::uint8_t> frozen_;
    std::vector<Scratch> scratch_;  // one a thread
};

}  // namespace dlpoly
