// The pairs of a sweep (see pair_rows.hpp).
#include "sweep/pair_rows.hpp"

#include <algorithm>
#include <utility>

#include "core/threads.hpp"

namespace dlpoly {

namespace {

constexpr std::int64_t beads_per_thread = 500;

}  // namespace

PairRows::PairRows(const PairTable& table, const Exclusions& exclusions, std::vector<double> reach, Frozen frozen)
    : species_count_(table.species()),
      exclusions_(exclusions),
      phases_(&chosen_phases()),
      reach_squared_(std::move(reach)),
      skip_frozen_(frozen == Frozen::skip_pairs) {
    for (double& one : reach_squared_) {
        range_ = std::max(range_, one);
        one *= one;
    }
}

int PairRows::useful_threads(const Particles& particles) {
    return static_cast<int>(std::clamp<std::int64_t>(particles.count() / beads_per_thread, 1, thread_limit()));
}

void PairRows::sort(const Box& box, const Particles& particles, [[maybe_unused]] int threads) {
    cells_.build(box, particles.position, range_);
    lattice_.number(box, cells_.most_shifts(), cells_.has_several_images());
    const std::vector<std::uint32_t>& order = cells_.order();
    const std::size_t beads = order.size();
    for (auto* array : {&x_, &y_, &z_}) {
        array->resize(beads + batch_lanes);
    }
    species_.resize(beads);
    frozen_.resize(beads);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        x_[k] = particles.position(id, 0);
        y_[k] = particles.position(id, 1);
        z_[k] = particles.position(id, 2);
        species_[k] = particles.species[order[k]];
        frozen_[k] = particles.frozen[order[k]];
    }
}

void PairRows::find_ranges(std::int32_t cell, Scratch& scratch) const {
    scratch.ranges.clear();
    scratch.ranges.push_back({cells_.start(cell), cells_.start(cell + 1), static_cast<std::uint32_t>(lattice_.zero)});
    cells_.neighbours(cell, scratch.neighbours);
    std::size_t candidates = batch_lanes + (cells_.start(cell + 1) - cells_.start(cell));
    for (const CellImage& other : scratch.neighbours) {
        const std::uint32_t begin = cells_.start(other.cell);
        const std::uint32_t stop = cells_.start(other.cell + 1);
        if (begin < stop) {
            const auto image =
                static_cast<std::uint32_t>(lattice_.zero + other.shift[0] + other.shift[1] * lattice_.stride[1] +
                                           other.shift[2] * lattice_.stride[2]);
            scratch.ranges.push_back({begin, stop, image});
            candidates += stop - begin;
        }
    }
    if (scratch.found.size() < candidates) {
        scratch.found.resize(candidates);
    }
}

void PairRows::Row::make_room(std::size_t pairs) {
    if (pairs <= i.size()) {
        return;
    }
    const std::size_t room = std::max(pairs, 2 * i.size());
    for (auto* array : {&i, &j, &term}) {
        array->resize(room);
    }
    image.resize(room);
    for (auto* array : {&dx, &dy, &dz, &squared}) {
        array->resize(room);
    }
}

void PairRows::find_pairs(std::int32_t place, Scratch& scratch) const {
    Row& row = scratch.row;
    row.count = 0;
    const SearchArguments arguments{x_.data(), y_.data(), z_.data(), lattice_.vectors.data(), range_ * range_};
    const std::int32_t length = cells_.row_length();
    for (std::int32_t cell = place * length; cell < (place + 1) * length; ++cell) {
        const std::uint32_t end = cells_.start(cell + 1);
        if (cells_.start(cell) == end) {
            continue;
        }
        find_ranges(cell, scratch);
        for (std::uint32_t i = cells_.start(cell); i < end; ++i) {
            scratch.ranges.front().begin = i + 1;
            const ListEntry* last =
                phases_->search(arguments, i, scratch.ranges.data(), scratch.ranges.size(), scratch.found.data());
            append(i, scratch.found.data(), last, row);
        }
    }
}

// Adds the pairs of a bead with those found around it. All are written, and counted where they act.
void PairRows::append(std::uint32_t i, const ListEntry* found, const ListEntry* last, Row& row) const {
    row.make_room(row.count + static_cast<std::size_t>(last - found) + 1);
    // Copies, because the compiler must suppose that storing images changes everything else.
    std::uint32_t* const to_i = row.i.data();
    std::uint32_t* const to_j = row.j.data();
    std::uint32_t* const to_term = row.term.data();
    std::uint8_t* const to_image = row.image.data();
    double* const to_dx = row.dx.data();
    double* const to_dy = row.dy.data();
    double* const to_dz = row.dz.data();
    double* const to_squared = row.squared.data();
    const double* const all_x = x_.data();
    const double* const all_y = y_.data();
    const double* const all_z = z_.data();
    const std::int32_t* const species = species_.data();
    const double* const reach_squared = reach_squared_.data();
    const ShiftRecord* const shifts = lattice_.vectors.data();
    const std::uint32_t* const order = cells_.order().data();
    const ImageCodes* const codes = has_images() ? lattice_.codes.data() : nullptr;
    const bool any_excluded = !exclusions_.empty();
    const bool skips = skip_frozen_ && frozen_[i] != 0;
    const auto first_term = static_cast<std::uint32_t>(species[i] * species_count_);
    const double x = all_x[i], y = all_y[i], z = all_z[i];
    std::size_t k = row.count;
    for (const ListEntry* entry = found; entry != last; ++entry) {
        const std::uint32_t j = entry->bead;
        const std::uint32_t term = first_term + static_cast<std::uint32_t>(species[j]);
        const ShiftRecord& shift = shifts[entry->image];
        const double dx = (x - all_x[j]) - shift.x;
        const double dy = (y - all_y[j]) - shift.y;
        const double dz = (z - all_z[j]) - shift.z;
        const double squared = dx * dx + dy * dy + dz * dz;
        to_i[k] = i;
        to_j[k] = j;
        to_term[k] = term;
        to_image[k] = codes != nullptr ? codes[entry->image].code[order[i] < order[j] ? 0 : 1] : std::uint8_t{0};
        to_dx[k] = dx;
        to_dy[k] = dy;
        to_dz[k] = dz;
        to_squared[k] = squared;
        // A bead and its own image have nothing to exchange, and coincident beads define no direction.
        bool acts = (i != j) & (squared < reach_squared[term]) & (squared != 0.0);
        acts = acts && !(skips && frozen_[j] != 0);
        if (any_excluded) {
            acts = acts && !exclusions_.contains(order[i], order[j]);
        }
        k += acts ? 1 : 0;
    }
    row.count = k;
}

void PairRows::visit(bool backward, [[maybe_unused]] int threads,
                     const std::function<void(const Row&, std::size_t place, std::size_t thread)>& visitor) {
    scratch_.resize(static_cast<std::size_t>(threads));
    const auto& groups = cells_.row_groups();
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
#endif
    {
        const auto thread = static_cast<std::size_t>(thread_number());
        Scratch& scratch = scratch_[thread];
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const std::vector<std::int32_t>& group = groups[backward ? groups.size() - 1 - g : g];
            const auto count = static_cast<std::int64_t>(group.size());
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 1)
#endif
            for (std::int64_t k = 0; k < count; ++k) {
                const std::int32_t place = group[static_cast<std::size_t>(k)];
                find_pairs(place, scratch);
                visitor(scratch.row, static_cast<std::size_t>(place), thread);
            }
        }
    }
}

}  // namespace dlpoly
