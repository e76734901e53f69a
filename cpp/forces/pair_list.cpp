// The pair list (see pair_list.hpp).
#include "forces/pair_list.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/threads.hpp"

namespace dlpoly {

namespace {

// A bead may have crossed into the next cell since the list was built, and its partner the other way.
constexpr std::int32_t crossings = 2;

}  // namespace

bool PairList::refresh(const Box& box, const Particles& particles, int threads) {
    Deformation deformation;
    if (beads_.empty() || order().size() != static_cast<std::size_t>(particles.count()) ||
        box.periodic() != periodic_ || (box.cell() != cell_ && !fits_deformed(box, deformation))) {
        evaluations_ = 0;
        return false;
    }
    if (box.cell() != shift_cell_) {
        number_shifts(box);
    }
    // Beads that were beyond range and skin may have come nearer by this, for each of the two. A slant s shortens no
    // vector by more than ½|s| of its length.
    const double shrinkage = 1.0 - std::min(1.0, deformation.growth.minCoeff()) + 0.5 * std::abs(deformation.slant);
    const double shrunk = 0.5 * shrinkage * std::sqrt(limit_squared_);
    const double allowed = std::max(0.0, allowed_ - shrunk);
    // Without a skin nothing is allowed, but beads that moved little still need no image.
    const double near = std::max(allowed * allowed, 0.0025 * limit_squared_);
    const double largest = deformation.slant == 0.0 ? follow<false>(box, particles, deformation, near, threads)
                                                    : follow<true>(box, particles, deformation, near, threads);
    ++evaluations_;
    displacement_ = std::sqrt(largest) + shrunk;
    return displacement_ < allowed_;
}

template <bool slanted>
double PairList::follow(const Box& box, const Particles& particles, const Deformation& deformation, double near,
                        [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = cells_.order();
    const std::size_t beads = order.size();
    const Vector3 growth = deformation.growth;
    double largest = 0.0;
    const double* position = particles.position.data();
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads) reduction(max : largest)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const double* place = position + 3 * std::size_t{order[k]};
        BeadRecord bead{place[0], place[1], place[2], 0};
        double dx = bead.x - growth[0] * x_[k];
        if constexpr (slanted) {
            dx -= deformation.slant * y_[k];
        }
        const double dy = bead.y - growth[1] * y_[k];
        const double dz = bead.z - growth[2] * z_[k];
        double squared = dx * dx + dy * dy + dz * dz;
        if (!(squared <= near)) {
            Vector3 moved(dx, dy, dz);
            const Vector3 cells = box.fractional(-moved);
            for (int axis = 0; axis < 3; ++axis) {
                const double crossed = periodic_[static_cast<std::size_t>(axis)] ? std::nearbyint(cells[axis]) : 0.0;
                if (std::abs(crossed) <= 1.0) {
                    moved += crossed * box.cell().row(axis).transpose();
                    bead.lattice +=
                        static_cast<std::int64_t>(crossed) * lattice_.stride[static_cast<std::size_t>(axis)];
                }
            }
            const double across = moved.squaredNorm();
            squared = across >= 0.0 ? across : std::numeric_limits<double>::infinity();
        }
        largest = std::max(largest, squared);
        beads_[k] = bead;
    }
    return largest;
}

bool PairList::fits_deformed(const Box& box, Deformation& deformation) const {
    const Matrix3& cell = box.cell();
    Matrix3 edges = cell.diagonal().asDiagonal();
    Matrix3 old_edges = cell_.diagonal().asDiagonal();
    edges(1, 0) = cell(1, 0);
    old_edges(1, 0) = cell_(1, 0);
    // Images get numbers of their own where a pair can have several, which only a new list finds out.
    if (cell != edges || cell_ != old_edges || cells_.has_several_images() ||
        !(box.widths().minCoeff() > 2.001 * range_)) {
        return false;
    }
    deformation.growth = edges.diagonal().cwiseQuotient(old_edges.diagonal());
    if (cell(1, 0) != 0.0 || cell_(1, 0) != 0.0) {
        // An offset that jumped by a whole edge gives the numbers of lattice vectors another meaning.
        const double change = cell(1, 0) - cell_(1, 0);
        deformation.slant = change / cell(1, 1);
        return deformation.growth == Vector3::Ones() && std::abs(change) < 0.25 * cell(0, 0) &&
               std::abs(deformation.slant) < 0.25;
    }
    return deformation.growth.minCoeff() > 0.8 && deformation.growth.maxCoeff() < 1.25;
}

// Numbers lattice vectors so that numbers add as the vectors do.
void PairList::number_shifts(const Box& box) {
    shift_cell_ = box.cell();
    const std::array<std::int32_t, 3> most = cells_.most_shifts();
    std::array<std::int32_t, 3> reach{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        reach[axis] = periodic_[axis] ? most[axis] + crossings : 0;
    }
    lattice_.number(box, reach, cells_.has_several_images());
}

void PairList::build(const Box& box, const Particles& particles, const PairTable& table, const Exclusions& exclusions,
                     double skin, double minimum_width, int threads) {
    cell_ = box.cell();
    range_ = table.range();
    periodic_ = box.periodic();
    cells_.build(box, particles.position, table.range() + skin, minimum_width, table.range());
    number_shifts(box);
    const std::vector<std::uint32_t>& order = cells_.order();
    const std::size_t beads = order.size();
    beads_.resize(beads + 1);
    species_.resize(beads);
    frozen_.resize(beads);
    for (auto* array : {&x_, &y_, &z_}) {
        array->resize(beads + batch_lanes);
    }
    bool any_frozen = false;
    double farthest = 0.0;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads) reduction(max : farthest) reduction(|| : any_frozen)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        x_[k] = particles.position(id, 0);
        y_[k] = particles.position(id, 1);
        z_[k] = particles.position(id, 2);
        beads_[k] = {x_[k], y_[k], z_[k], 0};
        farthest = std::max({farthest, std::abs(x_[k]), std::abs(y_[k]), std::abs(z_[k])});
        species_[k] = particles.species[order[k]];
        frozen_[k] = particles.frozen[order[k]];
        any_frozen = any_frozen || frozen_[k] != 0;
    }
    const double nowhere = std::numeric_limits<double>::quiet_NaN();
    beads_[beads] = {nowhere, nowhere, nowhere, 0};
    simple_ = table.species() == 1 && !any_frozen && exclusions.empty();
    const double limit = table.range() + skin;
    limit_squared_ = limit * limit;
    // What rounding can do to distances between beads and to displacements.
    const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * (farthest + cell_.cwiseAbs().sum());
    allowed_ = 0.5 * skin - 1e-9 * limit - rounding;
    term_limit_squared_.resize(table.terms());
    for (std::size_t term = 0; term < table.terms(); ++term) {
        const double reach = std::sqrt(table.reach_squared()[term]);
        term_limit_squared_[term] = reach > 0.0 ? (reach + skin) * (reach + skin) * (1.0 + 1e-12) : 0.0;
    }
    rows_.resize(static_cast<std::size_t>(cells_.cell_count() / cells_.row_length()));
    scratch_.resize(static_cast<std::size_t>(threads));
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
#endif
    {
        Scratch& scratch = scratch_[static_cast<std::size_t>(thread_number())];
        scratch.size = 0;
        scratch.entries.resize(table.terms());
        scratch.segments.resize(table.terms());
        const auto rows = static_cast<std::int32_t>(rows_.size());
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 1)
#endif
        for (std::int32_t k = 0; k < rows; ++k) {
            build_row(k, table, exclusions, scratch);
        }
    }
    size_ = 0;
    for (const Scratch& scratch : scratch_) {
        size_ += scratch.size;
    }
    displacement_ = 0.0;
    evaluations_ = 0;
}

// The neighbours of a cell as ranges of sorted beads; cells that follow each other make one range.
void PairList::find_ranges(std::int32_t cell, Scratch& scratch) const {
    scratch.ranges.clear();
    scratch.ranges.push_back({cells_.start(cell), cells_.start(cell + 1), static_cast<std::uint32_t>(lattice_.zero)});
    cells_.neighbours(cell, scratch.neighbours);
    for (const CellImage& other : scratch.neighbours) {
        const std::uint32_t begin = cells_.start(other.cell);
        const std::uint32_t end = cells_.start(other.cell + 1);
        if (begin == end) {
            continue;
        }
        const auto image =
            static_cast<std::uint32_t>(lattice_.zero + other.shift[0] * lattice_.stride[0] +
                                       other.shift[1] * lattice_.stride[1] + other.shift[2] * lattice_.stride[2]);
        if (CandidateRange& last = scratch.ranges.back(); last.end == begin && last.image == image) {
            last.end = end;
        } else {
            scratch.ranges.push_back({begin, end, image});
        }
    }
}

void PairList::build_row(std::int32_t row, const PairTable& table, const Exclusions& exclusions, Scratch& scratch) {
    ListRow& list = rows_[static_cast<std::size_t>(row)];
    list.entries.clear();
    list.segments.clear();
    list.blocks.clear();
    const ListEntry filler{static_cast<std::uint32_t>(cells_.order().size()),
                           static_cast<std::uint32_t>(lattice_.zero)};
    const SearchArguments arguments{x_.data(), y_.data(), z_.data(), lattice_.vectors.data(), limit_squared_};
    const auto fill_up = [&filler](std::vector<ListEntry>& entries) {
        entries.resize((entries.size() + batch_lanes - 1) / batch_lanes * batch_lanes, filler);
    };
    const std::int32_t length = cells_.row_length();
    for (std::int32_t cell = row * length; cell < (row + 1) * length; ++cell) {
        if (cells_.start(cell) == cells_.start(cell + 1)) {
            continue;
        }
        find_ranges(cell, scratch);
        std::size_t candidates = batch_lanes;
        for (const CandidateRange& range : scratch.ranges) {
            candidates += range.end - range.begin;
        }
        if (scratch.found.size() < candidates) {
            scratch.found.resize(candidates);
        }
        for (std::uint32_t bead = cells_.start(cell); bead < cells_.start(cell + 1); ++bead) {
            scratch.ranges.front().begin = bead + 1;
            const ListEntry* end =
                phases_->search(arguments, bead, scratch.ranges.data(), scratch.ranges.size(), scratch.found.data());
            const auto found = static_cast<std::size_t>(end - scratch.found.data());
            if (!simple_) {
                distribute(bead, end, table, exclusions, scratch);
            } else if (found > 0) {
                const auto first = static_cast<std::uint32_t>(list.entries.size());
                list.entries.insert(list.entries.end(), scratch.found.begin(),
                                    scratch.found.begin() + static_cast<std::ptrdiff_t>(found));
                fill_up(list.entries);
                list.segments.push_back({bead, first, static_cast<std::uint32_t>(list.entries.size())});
                scratch.size += static_cast<std::int64_t>(found);
            }
        }
    }
    if (simple_) {
        if (!list.segments.empty()) {
            list.blocks.push_back({0, 0, list.segments.size()});
        }
        return;
    }
    for (std::size_t term = 0; term < scratch.entries.size(); ++term) {
        std::vector<ListSegment>& segments = scratch.segments[term];
        if (segments.empty()) {
            continue;
        }
        const std::size_t first = list.segments.size();
        for (const ListSegment& segment : segments) {
            const auto start = static_cast<std::uint32_t>(list.entries.size());
            list.entries.insert(list.entries.end(), scratch.entries[term].begin() + segment.first,
                                scratch.entries[term].begin() + segment.end);
            fill_up(list.entries);
            list.segments.push_back({segment.bead, start, static_cast<std::uint32_t>(list.entries.size())});
        }
        list.blocks.push_back({static_cast<std::uint32_t>(term), first, list.segments.size()});
        scratch.size += static_cast<std::int64_t>(scratch.entries[term].size());
        scratch.entries[term].clear();
        segments.clear();
    }
}

// Sorts the beads found around one bead by the entry of the pair table and drops those that never act on it.
void PairList::distribute(std::uint32_t bead, const ListEntry* end, const PairTable& table,
                          const Exclusions& exclusions, Scratch& scratch) const {
    const std::int32_t own = species_[bead];
    const std::uint32_t id = order()[bead];
    const bool any_excluded = !exclusions.empty();
    for (const ListEntry* entry = scratch.found.data(); entry != end; ++entry) {
        const std::uint32_t j = entry->bead;
        if ((frozen_[bead] != 0 && frozen_[j] != 0) || (any_excluded && exclusions.contains(id, order()[j]))) {
            continue;
        }
        const std::uint32_t term = table.term(std::min(own, species_[j]), std::max(own, species_[j]));
        const ShiftRecord& shift = lattice_.vectors[entry->image];
        const double dx = (x_[bead] - x_[j]) - shift.x;
        const double dy = (y_[bead] - y_[j]) - shift.y;
        const double dz = (z_[bead] - z_[j]) - shift.z;
        if (!(dx * dx + dy * dy + dz * dz < term_limit_squared_[term])) {
            continue;
        }
        std::vector<ListSegment>& segments = scratch.segments[term];
        if (segments.empty() || segments.back().bead != bead) {
            const auto first = static_cast<std::uint32_t>(scratch.entries[term].size());
            segments.push_back({bead, first, first});
        }
        scratch.entries[term].push_back(*entry);
        ++segments.back().end;
    }
}

}  // namespace dlpoly
