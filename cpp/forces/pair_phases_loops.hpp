// The phases as loops that compilers vectorise for the instruction set of the file that includes this.
#pragma once

#include "core/bead_words.hpp"
#include "forces/pair_phases.hpp"

namespace dlpoly::DLPOLY_SIMD {

static constexpr double grid_reach = 0x1p51;  // largest_term of exact_sum.hpp
// Added to a number below 2^51 it leaves the number, rounded half to even, in the low bits.
static constexpr double rounding_offset = 0x1.8p52;

// Unsigned, so that numbers beyond the grid, which the caller finds and drops, may wrap.
static inline uint64_t to_grid(double value) {
    return __builtin_bit_cast(uint64_t, value + rounding_offset) - __builtin_bit_cast(uint64_t, rounding_offset);
}

static inline size_t whole_lanes(size_t count) { return (count + batch_lanes - 1) / batch_lanes * batch_lanes; }

// Fills the batch up to whole lanes with copies of its last pair, so that loops need no remainder; as the copies are of
// distance zero along every axis they exert no force.
static inline void fill_up(PairBatch& batch) {
    const size_t last = batch.size - 1;
    for (size_t k = batch.size; k < whole_lanes(batch.size); ++k) {
        batch.i.values[k] = batch.i.values[last];
        batch.j.values[k] = batch.j.values[last];
        batch.image.values[k] = batch.image.values[last];
        batch.dx.values[k] = 0.0;
        batch.dy.values[k] = 0.0;
        batch.dz.values[k] = 0.0;
        batch.distance_squared.values[k] = batch.distance_squared.values[last];
    }
}

[[maybe_unused]] static ListEntry* search(const SearchArguments& a, uint32_t bead, const CandidateRange* ranges,
                                          size_t count, ListEntry* out) {
    // Copies, because the compiler must suppose that storing entries changes the arguments.
    const double* const all_x = a.x;
    const double* const all_y = a.y;
    const double* const all_z = a.z;
    const double limit_squared = a.limit_squared;
    const double x = all_x[bead];
    const double y = all_y[bead];
    const double z = all_z[bead];
    constexpr uint32_t chunk = 64;
    for (size_t r = 0; r < count; ++r) {
        const CandidateRange range = ranges[r];
        const ShiftRecord shift = a.shifts[range.image];
        for (uint32_t first = range.begin; first < range.end; first += chunk) {
            const uint32_t size = range.end - first < chunk ? range.end - first : chunk;
            const double* const other_x = all_x + first;
            const double* const other_y = all_y + first;
            const double* const other_z = all_z + first;
            int64_t near[chunk];
            for (size_t k = 0; k < size; ++k) {
                const double dx = (x - other_x[k]) - shift.x;
                const double dy = (y - other_y[k]) - shift.y;
                const double dz = (z - other_z[k]) - shift.z;
                near[k] = dx * dx + dy * dy + dz * dz < limit_squared ? 1 : 0;
            }
            for (uint32_t k = 0; k < size; ++k) {
                *out = {first + k, range.image};
                out += near[k];
            }
        }
    }
    return out;
}

// Runs the given step for every chunk of the list; step(own, entries, size) appends to the batch, returns its new size.
template <class Step>
static inline bool walk_segments(FilterArguments& a, PairBatch& batch, const Step& step) {
    size_t size = batch.size;
    bool ended = true;
    while (a.segment < a.last_segment) {
        const ListSegment segment = a.segments[a.segment];
        uint32_t entry = a.entry;
        const size_t begin = size;
        const BeadRecord own = a.beads[segment.bead];
        while (entry < segment.end && size <= batch_capacity - batch_lanes) {
            size = step(segment.bead, own, a.entries + entry, size);
            entry += batch_lanes;
        }
        if (size > begin) {
            batch.run.values[batch.runs++] = {segment.bead, static_cast<uint32_t>(begin), static_cast<uint32_t>(size)};
        }
        if (entry < segment.end) {
            a.entry = entry;
            ended = false;
            break;
        }
        ++a.segment;
        a.entry = a.segment < a.last_segment ? a.segments[a.segment].first : 0;
        if (size > batch_capacity - batch_lanes) {
            ended = a.segment == a.last_segment;
            break;
        }
    }
    batch.size = size;
    if (size > 0) {
        fill_up(batch);
    }
    return ended;
}

[[maybe_unused]] static bool filter(FilterArguments& a, PairBatch& batch) {
    const double reach_squared = batch.reach_squared;
    return walk_segments(a, batch, [&](uint32_t bead, const BeadRecord& own, const ListEntry* entries, size_t size) {
        double dx[batch_lanes], dy[batch_lanes], dz[batch_lanes], squared[batch_lanes];
        int64_t image[batch_lanes];
        int64_t shifted = 0;
        for (size_t k = 0; k < batch_lanes; ++k) {
            const BeadRecord& other = a.beads[entries[k].bead];
            dx[k] = own.x - other.x;
            dy[k] = own.y - other.y;
            dz[k] = own.z - other.z;
            image[k] = int64_t{entries[k].image} + other.lattice - own.lattice;
            shifted |= image[k] ^ a.zero;
        }
        if (shifted != 0) {
            for (size_t k = 0; k < batch_lanes; ++k) {
                dx[k] -= a.shifts[image[k]].x;
                dy[k] -= a.shifts[image[k]].y;
                dz[k] -= a.shifts[image[k]].z;
            }
        }
        for (size_t k = 0; k < batch_lanes; ++k) {
            squared[k] = dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k];
        }
        for (size_t k = 0; k < batch_lanes; ++k) {
            batch.i.values[size] = bead;
            batch.j.values[size] = entries[k].bead;
            batch.image.values[size] = static_cast<uint32_t>(image[k]);
            batch.dx.values[size] = dx[k];
            batch.dy.values[size] = dy[k];
            batch.dz.values[size] = dz[k];
            batch.distance_squared.values[size] = squared[k];
            size += squared[k] < reach_squared ? 1 : 0;
        }
        return size;
    });
}

// −γ w^D (e·v_ij) and σ w^R ζ/√Δt of every pair, over r once more: factors of the vector r_i − r_j.
static inline void motion_factors(const MotionArguments& a, const PairBatch& batch, const double* __restrict projection,
                                  const int32_t* __restrict words, BatchResult& result) {
    const size_t count = whole_lanes(batch.size);
    const double* __restrict squared = batch.distance_squared.values;
    const uint32_t* __restrict first = batch.i.values;
    const uint32_t* __restrict second = batch.j.values;
    double* __restrict drag = result.drag.values;
    double* __restrict noise = result.noise.values;
    for (size_t k = 0; k < count; ++k) {
        const double distance = __builtin_sqrt(squared[k]);
        // A bead and its own image, and coincident beads, define no direction that could be damped.
        const bool acts = (distance < a.cutoff) & (distance != 0.0) & (first[k] != second[k]);
        const double weight = 1.0 - distance / a.cutoff;
        const double damping = -a.drag * weight * weight * projection[k] / squared[k];
        const double zeta = word_to_noise * words[k];
        const double kicking = a.noise * weight * zeta * a.inverse_root_timestep / distance;
        drag[k] = acts ? damping : 0.0;
        noise[k] = acts ? kicking : 0.0;
    }
}

// Tells several images of one pair apart; the same number from either bead.
static inline uint32_t image_code(const MotionArguments& a, const PairBatch& batch, size_t k) {
    if (a.image_codes == nullptr) {
        return 0;
    }
    const bool forward = a.ids[batch.i.values[k]] < a.ids[batch.j.values[k]];
    return a.image_codes[batch.image.values[k]].code[forward ? 0 : 1];
}

[[maybe_unused]] static void motion(const MotionArguments& a, const PairBatch& batch, BatchResult& result) {
    double projection[batch_capacity + batch_lanes];
    int32_t words[batch_capacity + batch_lanes];
    const size_t count = whole_lanes(batch.size);
    for (size_t k = 0; k < count; ++k) {
        const MotionRecord& i = a.beads[batch.i.values[k]];
        const MotionRecord& j = a.beads[batch.j.values[k]];
        projection[k] =
            batch.dx.values[k] * (i.x - j.x) + batch.dy.values[k] * (i.y - j.y) + batch.dz.values[k] * (i.z - j.z);
        words[k] = mix_words(static_cast<uint32_t>(i.word), static_cast<uint32_t>(j.word), image_code(a, batch, k));
    }
    motion_factors(a, batch, projection, words, result);
}

// Adds the parts to one factor, in the order in which they were always added.
static inline double total_factor(const BatchResult& result, bool motion, size_t k) {
    return motion ? result.conservative.values[k] + result.drag.values[k] + result.noise.values[k]
                  : result.conservative.values[k];
}

template <bool motion>
static inline bool round_forces(const PairBatch& batch, BatchResult& result, double scale) {
    const size_t count = whole_lanes(batch.size);
    int64_t beyond = 0;
    for (size_t k = 0; k < count; ++k) {
        const double factor = total_factor(result, motion, k);
        const double x = factor * batch.dx.values[k] * scale;
        const double y = factor * batch.dy.values[k] * scale;
        const double z = factor * batch.dz.values[k] * scale;
        const bool fits =
            (__builtin_fabs(x) < grid_reach) & (__builtin_fabs(y) < grid_reach) & (__builtin_fabs(z) < grid_reach);
        beyond |= fits ? 0 : 1;
        result.force.values[k] = {static_cast<int64_t>(to_grid(x)), static_cast<int64_t>(to_grid(y)),
                                  static_cast<int64_t>(to_grid(z)), 0};
    }
    return beyond == 0;
}

[[maybe_unused]] static bool round(const PairBatch& batch, BatchResult& result, bool motion, double scale) {
    return motion ? round_forces<true>(batch, result, scale) : round_forces<false>(batch, result, scale);
}

[[maybe_unused]] static void add(const PairBatch& batch, const BatchResult& result, GridForce* sums) {
    for (size_t r = 0; r < batch.runs; ++r) {
        const PairRun run = batch.run.values[r];
        GridForce own = {0, 0, 0, 0};
        for (uint32_t k = run.begin; k < run.end; ++k) {
            const GridForce force = result.force.values[k];
            own = {own.x + force.x, own.y + force.y, own.z + force.z, 0};
            GridForce& other = sums[batch.j.values[k]];
            other = {other.x - force.x, other.y - force.y, other.z - force.z, 0};
        }
        GridForce& sum = sums[run.bead];
        sum = {sum.x + own.x, sum.y + own.y, sum.z + own.z, 0};
    }
}

// Sums the rounded virial of one part along one pair of axes.
static inline int64_t sum_virial(const double* __restrict factor, const double* __restrict a,
                                 const double* __restrict b, size_t count, double scale) {
    uint64_t sum = 0;
    for (size_t k = 0; k < count; ++k) {
        const double product = a[k] * b[k] * scale;
        sum += to_grid(factor[k] * product);
    }
    return static_cast<int64_t>(sum);
}

static inline bool fits_grid(const double* __restrict factor, const double* __restrict squared, size_t count,
                             double scale) {
    int64_t beyond = 0;
    for (size_t k = 0; k < count; ++k) {
        const double reach = squared[k] * scale;
        beyond |= __builtin_fabs(factor[k]) * reach < grid_reach ? 0 : 1;
    }
    return beyond == 0;
}

[[maybe_unused]] static bool observe(const PairBatch& batch, const BatchResult& result, bool motion, double scale,
                                     ObservedSums& sums) {
    const double* parts[3] = {result.conservative.values, result.drag.values, result.noise.values};
    const double* d[3] = {batch.dx.values, batch.dy.values, batch.dz.values};
    sums = ObservedSums{};
    int64_t beyond = 0;
    uint64_t total = 0;
    for (size_t k = 0; k < batch.size; ++k) {
        const double energy = result.energy.values[k] * scale;
        beyond |= __builtin_fabs(energy) < grid_reach ? 0 : 1;
        total += to_grid(energy);
    }
    sums.energy = static_cast<int64_t>(total);
    bool fits = beyond == 0;
    for (size_t part = 0; part < (motion ? 3U : 1U); ++part) {
        fits = fits && fits_grid(parts[part], batch.distance_squared.values, batch.size, scale);
        size_t entry = 0;
        for (size_t a = 0; a < 3; ++a) {
            for (size_t b = a; b < 3; ++b) {
                sums.virial[part][entry++] = sum_virial(parts[part], d[a], d[b], batch.size, scale);
            }
        }
    }
    return fits;
}

}  // namespace dlpoly::DLPOLY_SIMD
