// The pair list: for every bead the beads that may come within range before any has moved half the skin.
//
// It is built from link cells and kept while it is complete: while no bead is farther than half the skin from where it
// was when the list was built, whole cells that it has crossed since taken off. Where an orthorhombic cell has changed
// or tilted along x, places follow it, and what lengths may have shrunk by is taken off the skin. Pairs are stored by
// the rows of cells they belong to, sorted by the entry of the pair table; pairs that never act are left out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cells/link_cells.hpp"
#include "core/box.hpp"
#include "core/particles.hpp"
#include "forces/exclusions.hpp"
#include "forces/lattice_shifts.hpp"
#include "forces/pair_phases.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly {

// The pairs of one row of cells.
struct ListRow {
    struct Block {
        std::uint32_t term;
        std::size_t first;  // segment
        std::size_t last;
    };
    std::vector<ListEntry> entries;
    std::vector<ListSegment> segments;
    std::vector<Block> blocks;
};

class PairList {
  public:
    explicit PairList(const Phases& phases) : phases_(&phases) {}

    // Takes over the positions; false when the list does not fit them and has to be built.
    [[nodiscard]] bool refresh(const Box& box, const Particles& particles, int threads);
    // Builds the list with a skin, without the excluded pairs. `minimum_width` as LinkCells::build has it.
    void build(const Box& box, const Particles& particles, const PairTable& table, const Exclusions& exclusions,
               double skin, double minimum_width, int threads);
    // The next refresh asks for a new list, whatever the positions.
    void forget() noexcept { beads_.clear(); }

    [[nodiscard]] const LinkCells& cells() const noexcept { return cells_; }
    [[nodiscard]] const ListRow& row(std::int32_t row) const noexcept { return rows_[static_cast<std::size_t>(row)]; }
    // Beads in sorted order, and one more that is nowhere.
    [[nodiscard]] const std::vector<BeadRecord>& beads() const noexcept { return beads_; }
    [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return cells_.order(); }
    [[nodiscard]] const std::vector<ShiftRecord>& shifts() const noexcept { return lattice_.vectors; }
    [[nodiscard]] std::int64_t zero_shift() const noexcept { return lattice_.zero; }
    // By number of the lattice vector; empty when pairs have one image only.
    [[nodiscard]] const std::vector<ImageCodes>& image_codes() const noexcept { return lattice_.codes; }

    // Entries of the list, without those that fill up lanes.
    [[nodiscard]] std::int64_t size() const noexcept { return size_; }
    // How far the fastest bead has come since the list was built, and in how many evaluations.
    [[nodiscard]] double displacement() const noexcept { return displacement_; }
    [[nodiscard]] std::int64_t evaluations() const noexcept { return evaluations_; }

  private:
    struct Scratch {
        std::vector<CellImage> neighbours;
        std::vector<CandidateRange> ranges;
        std::vector<ListEntry> found;
        std::vector<std::vector<ListEntry>> entries;  // by term
        std::vector<std::vector<ListSegment>> segments;
        std::int64_t size = 0;
    };

    void number_shifts(const Box& box);
    // What the cell did to places since the list was built: x → growth_x x + slant y, y → growth_y y, z → growth_z z.
    struct Deformation {
        Vector3 growth = Vector3::Ones();
        double slant = 0.0;
    };
    // Whether the list may serve another cell than the one it was built in; then also how that differs.
    [[nodiscard]] bool fits_deformed(const Box& box, Deformation& deformation) const;
    // Takes over positions; returns the largest square of a distance that a bead has come from its place.
    template <bool slanted>
    [[nodiscard]] double follow(const Box& box, const Particles& particles, const Deformation& deformation, double near,
                                int threads);
    void build_row(std::int32_t row, const PairTable& table, const Exclusions& exclusions, Scratch& scratch);
    void find_ranges(std::int32_t cell, Scratch& scratch) const;
    void distribute(std::uint32_t bead, const ListEntry* end, const PairTable& table, const Exclusions& exclusions,
                    Scratch& scratch) const;

    const Phases* phases_;
    LinkCells cells_;
    std::vector<ListRow> rows_;
    std::vector<Scratch> scratch_;
    std::vector<BeadRecord> beads_;
    std::vector<double> x_, y_, z_;  // in sorted order, when the list was built
    std::vector<std::int32_t> species_;
    std::vector<std::uint8_t> frozen_;
    LatticeShifts lattice_;
    std::vector<double> term_limit_squared_;
    double limit_squared_ = 0.0;
    double range_ = 0.0;
    double allowed_ = 0.0;                  // displacement
    Matrix3 cell_ = Matrix3::Zero();        // when the list was built
    Matrix3 shift_cell_ = Matrix3::Zero();  // that the lattice vectors belong to
    std::array<bool, 3> periodic_{};
    bool simple_ = false;  // one species, nothing frozen, nothing excluded
    std::int64_t size_ = 0;
    double displacement_ = 0.0;
    std::int64_t evaluations_ = 0;
};

}  // namespace dlpoly
