// The pass over all pairs of the fast path, written once and compiled for every instruction set.
//
// Included by one translation unit for each instruction set, after a header that defines a `Lanes` type there.
// Everything lives in the namespace DLPOLY_SIMD so that code compiled for one processor can never be linked into
// another's path.
//
// A row of cells is handled in pieces of up to eight blocks of one or two cells, in phases that keep their buffers in
// the first level cache: collect the shadows of all candidates of a block once; test them against each bead of the
// block; evaluate the accepted pairs, as many at a time as a vector holds; add up and advance the beads. Every pair is
// met from both of its beads ("full list"): that costs arithmetic, and saves scattered additions and all conflicts
// between threads.
#pragma once

#include <stdint.h>

#include "fast/arguments.hpp"
#include "fast/scalar.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

inline constexpr int blocks_a_piece = 8;
inline constexpr int candidate_stride = most_candidates + 128;  // room for whole vectors past the end
inline constexpr int accepted_stride = 96;
inline constexpr int most_beads = 512;  // of a piece

template <class Record>
struct alignas(64) Workspace {
    uint8_t x[blocks_a_piece * candidate_stride];
    uint8_t y[blocks_a_piece * candidate_stride];
    uint8_t z[blocks_a_piece * candidate_stride];
    uint32_t offset[blocks_a_piece * candidate_stride];    // of the candidate's record, bytes
    uint8_t accepted[most_beads * accepted_stride + 256];  // numbers of candidates, for each bead
    int32_t accepted_count[most_beads];                    // −1: the direct way
    alignas(64) typename Record::Fixed impulse[most_beads * 4];
    uint32_t tag[most_beads + 16];
    uint32_t word[most_beads + 16];
};

static_assert(sizeof(Workspace<DoubleRecord>) <= workspace_bytes);

// A run of consecutive beads.
struct Span {
    int32_t begin, end;
};

// The cells that can hold neighbours of a block: nine rows, each one run of beads or two where the box wraps.
struct Candidates {
    Span spans[27];
    int count;
};

template <class Record>
DLPOLY_INLINE Candidates candidates_of(const PassArguments<Record>& a, const int32_t* rows, int32_t first,
                                       int32_t last) {
    Candidates result;
    result.count = 0;
    const int32_t cells = a.cells_x;
    for (int k = 0; k < 9; ++k) {
        const int32_t* start = a.row_start + static_cast<int64_t>(rows[k]) * cells;
        if (first == 0) {
            result.spans[result.count++] = {start[cells - 1], start[cells]};
        }
        result.spans[result.count++] = {start[first == 0 ? 0 : first - 1], start[last == cells ? cells : last + 1]};
        if (last == cells) {
            result.spans[result.count++] = {start[0], start[1]};
        }
    }
    return result;
}

// The places of a row and of its eight neighbours, itself first.
template <class Record>
inline void neighbour_rows(const PassArguments<Record>& a, int32_t place, int32_t* rows) {
    const int32_t row = a.row_at[place];
    const int32_t y = row % a.rows_y;
    const int32_t z = row / a.rows_y;
    int count = 0;
    rows[count++] = place;
    for (int32_t dz = -1; dz <= 1; ++dz) {
        const int32_t other_z = z + dz < 0 ? a.rows_z - 1 : z + dz == a.rows_z ? 0 : z + dz;
        for (int32_t dy = -1; dy <= 1; ++dy) {
            const int32_t other_y = y + dy < 0 ? a.rows_y - 1 : y + dy == a.rows_y ? 0 : y + dy;
            if (dz != 0 || dy != 0) {
                rows[count++] = a.row_rank[other_z * a.rows_y + other_y];
            }
        }
    }
}

// One bead against all candidates of its block, one pair after another: the plain path, and the way out where a buffer
// of the vector path would overflow. Sums are 64 bits wide.
template <bool one_kind, bool drag, bool observe, class Record>
inline void direct_bead(PassArguments<Record>& a, const Candidates& candidates, int32_t i,
                        typename Record::Fixed* impulse, double* observed) {
    using Real = typename Record::Arithmetic;
    const Record& self = a.sorted[i];
    const uint32_t kind = one_kind ? 0 : self.tag >> kind_shift;
    const PairRow<Real>& row = a.rows[kind];
    const Real inverse_mass = a.inverse_mass[kind];
    int64_t sum_x = 0, sum_y = 0, sum_z = 0;
    for (int s = 0; s < candidates.count; ++s) {
        for (int32_t j = candidates.spans[s].begin; j < candidates.spans[s].end; ++j) {
            if (j == i) {
                continue;
            }
            const Record& other = a.sorted[j];
            const uint32_t pair = one_kind ? 0 : other.tag >> kind_shift;
            const Real dx = static_cast<Real>(wrapped_difference(self.x, other.x));
            const Real dy = static_cast<Real>(wrapped_difference(self.y, other.y));
            const Real dz = static_cast<Real>(wrapped_difference(self.z, other.z));
            const Real ex = a.metric_x * dx, ey = a.metric_y * dy, ez = a.metric_z * dz;
            const Real distance_squared = ex * dx + ey * dy + ez * dz;
            const Real distance = square_root(distance_squared);
            const Real w = Real(1) - distance * row.inverse_cutoff[pair];
            if (!(w > Real(0))) {
                continue;
            }
            const Real inverse = distance > Real(0) ? Real(1) / distance : Real(0);
            const Real slope = w * inverse;
            const Real conservative = row.repulsion[pair];
            Real strength = conservative;
            Real drag_part = 0, noise_part = 0;
            if constexpr (drag) {
                const Real other_inverse_mass = one_kind ? inverse_mass : a.inverse_mass[pair];
                Real vx, vy, vz;
                if constexpr (one_kind) {
                    vx = static_cast<Real>(self.px - other.px);
                    vy = static_cast<Real>(self.py - other.py);
                    vz = static_cast<Real>(self.pz - other.pz);
                } else {
                    vx = static_cast<Real>(self.px) * inverse_mass - static_cast<Real>(other.px) * other_inverse_mass;
                    vy = static_cast<Real>(self.py) * inverse_mass - static_cast<Real>(other.py) * other_inverse_mass;
                    vz = static_cast<Real>(self.pz) * inverse_mass - static_cast<Real>(other.pz) * other_inverse_mass;
                }
                const Real approach = (ex * vx + ey * vy + ez * vz) * inverse;
                drag_part = -row.drag[pair] * w * approach;
                noise_part = row.noise[pair] * static_cast<Real>(mix_words(self.word, other.word));
                strength += drag_part + noise_part;
            }
            const Real factor = strength * slope;
            sum_x += nearest(factor * dx);
            sum_y += nearest(factor * dy);
            sum_z += nearest(factor * dz);
            if constexpr (observe) {
                observed[0] += row.energy[pair] * w * w;
                const double products[6] = {double(dx) * dx, double(dy) * dy, double(dz) * dz,
                                            double(dx) * dy, double(dx) * dz, double(dy) * dz};
                for (int k = 0; k < 6; ++k) {
                    observed[1 + k] += conservative * slope * products[k];
                    observed[7 + k] += drag_part * slope * products[k];
                    observed[13 + k] += noise_part * slope * products[k];
                }
            }
        }
    }
    const int64_t sums[3] = {sum_x, sum_y, sum_z};
    for (int axis = 0; axis < 3; ++axis) {
        impulse[axis] = static_cast<typename Record::Fixed>(sums[axis]);
        a.overflow |= impulse[axis] == sums[axis] ? 0U : 1U;
    }
}

// Adds a step's impulses to a bead and moves it: leapfrog, p += I, x += Δt p/m, counting crossings of the box.
template <class Record>
inline void advance_bead(PassArguments<Record>& a, const Record& bead, const typename Record::Fixed* impulse,
                         Record& out) {
    using Fixed = typename Record::Fixed;
    using Real = typename Record::Arithmetic;
    const uint32_t kind = bead.tag >> kind_shift;
    const Real drift = a.drift[kind];
    out = bead;
    if (drift != Real(0)) {  // frozen beads keep still, whatever pushes them; a sum that wraps is out of range below
        out.px = wrapped_sum(bead.px, impulse[0]);
        out.py = wrapped_sum(bead.py, impulse[1]);
        out.pz = wrapped_sum(bead.pz, impulse[2]);
    }
    constexpr int unused_bits = static_cast<int>(8 * sizeof(Fixed)) - Record::position_bits;
    const Fixed step_x = shifted_up<Fixed>(nearest(static_cast<Real>(out.px) * drift), unused_bits);
    const Fixed step_y = shifted_up<Fixed>(nearest(static_cast<Real>(out.py) * drift), unused_bits);
    const Fixed step_z = shifted_up<Fixed>(nearest(static_cast<Real>(out.pz) * drift), unused_bits);
    out.x = wrapped_sum(bead.x, step_x);
    out.y = wrapped_sum(bead.y, step_y);
    out.z = wrapped_sum(bead.z, step_z);
    using Unsigned = typename UnsignedOf<Fixed>::type;
    const auto crossed = [](Fixed before, Fixed after, Fixed step) {
        return step >= 0 ? (after < before ? 1 : 0) : (after > before ? -1 : 0);
    };
    const int cx = crossed(bead.x, out.x, step_x);
    const int cy = crossed(bead.y, out.y, step_y);
    const int cz = crossed(bead.z, out.z, step_z);
    if ((cx | cy | cz) != 0) {
        int32_t* image = a.images + 3 * static_cast<int64_t>(bead.tag & id_mask);
        image[0] += cx;
        image[1] += cy;
        image[2] += cz;
    }
    const auto out_of_range = [](Fixed p) {
        constexpr Unsigned range = Unsigned{1} << Record::momentum_bits;
        return (static_cast<Unsigned>(p) + range) >> (Record::momentum_bits + 1);
    };
    a.overflow |= static_cast<uint64_t>(out_of_range(out.px) | out_of_range(out.py) | out_of_range(out.pz));
}

// Adds the impulses of bonded terms and leaves zeros for the next step.
template <class Record>
inline void add_bonded(PassArguments<Record>& a, Workspace<Record>& work, int32_t begin, int32_t end) {
    using Fixed = typename Record::Fixed;
    for (int32_t i = begin; i < end; ++i) {
        const uint32_t id = a.sorted[i].tag & id_mask;
        if (id >= a.bonded_end) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            int64_t& bonded = a.bonded[3 * static_cast<int64_t>(id) + axis];
            Fixed& impulse = work.impulse[4 * (i - begin) + axis];
            const int64_t sum = impulse + bonded;
            impulse = static_cast<Fixed>(sum);
            a.overflow |= impulse == sum ? 0U : 1U;
            bonded = 0;
        }
    }
}

// Adds what is held to the impulses of the last pass of a thermostat step.
template <class Record>
inline void add_held(const PassArguments<Record>& a, Workspace<Record>& work, int32_t begin, int32_t end) {
    for (int32_t i = begin; i < end; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            typename Record::Fixed& impulse = work.impulse[4 * (i - begin) + axis];
            impulse = wrapped_sum(impulse, a.held[4 * static_cast<int64_t>(i) + axis]);
        }
    }
}

// Estimates of momenta for the next pass of a thermostat step, in integers: what is not in them is held, so that
// nothing is rounded away.
template <class Record>
inline void estimate_momenta(const PassArguments<Record>& a, const Workspace<Record>& work, int32_t begin,
                             int32_t end) {
    using Fixed = typename Record::Fixed;
    for (int32_t i = begin; i < end; ++i) {
        const Record& bead = a.sorted[i];
        Record& out = a.advanced[i];
        out = bead;
        Fixed* held = a.held + 4 * static_cast<int64_t>(i);
        if (a.drift[bead.tag >> kind_shift] == typename Record::Arithmetic(0)) {
            held[0] = held[1] = held[2] = 0;  // frozen
            continue;
        }
        const Fixed* impulse = work.impulse + 4 * (i - begin);
        Fixed momentum[3] = {bead.px, bead.py, bead.pz};
        for (int axis = 0; axis < 3; ++axis) {
            if (a.stage == Stage::drag) {
                const Fixed half = wrapped_sum(held[axis], impulse[axis]) >> 1;
                momentum[axis] = wrapped_sum(momentum[axis], wrapped_difference(half, Fixed(held[axis] >> 2)));
                held[axis] = wrapped_difference(held[axis], half);
            } else {
                const Fixed quarter = impulse[axis] >> 2;
                momentum[axis] = wrapped_sum(momentum[axis], quarter);
                held[axis] = a.stage == Stage::noise ? impulse[axis] : wrapped_difference(impulse[axis], quarter);
            }
        }
        out.px = momentum[0];
        out.py = momentum[1];
        out.pz = momentum[2];
    }
}

// Takes the prediction of the last step out of the impulses and keeps that of the next one.
template <class Record>
inline void take_prediction(const PassArguments<Record>& a, Workspace<Record>& work, int32_t begin, int32_t end) {
    using Real = typename Record::Arithmetic;
    using Fixed = typename Record::Fixed;
    for (int32_t i = begin; i < end; ++i) {
        const bool frozen = a.drift[a.sorted[i].tag >> kind_shift] == Real(0);
        for (int axis = 0; axis < 3; ++axis) {
            const int64_t at = 4 * static_cast<int64_t>(i) + axis;
            Fixed& impulse = work.impulse[4 * (i - begin) + axis];
            a.held_next[at] =
                frozen ? Fixed(0) : static_cast<Fixed>(nearest(static_cast<Real>(impulse) * a.prediction));
            impulse = wrapped_difference(impulse, a.held[at]);
        }
    }
}

template <class Record>
inline void add_prediction(const PassArguments<Record>& a, int32_t begin, int32_t end) {
    for (int32_t i = begin; i < end; ++i) {
        const typename Record::Fixed* held = a.held_next + 4 * static_cast<int64_t>(i);
        Record& out = a.advanced[i];
        out.px = wrapped_sum(out.px, held[0]);
        out.py = wrapped_sum(out.py, held[1]);
        out.pz = wrapped_sum(out.pz, held[2]);
    }
}

// Everything a piece of beads still needs once its impulses are known: kept (last step), or used.
template <bool last, class Lanes, class Record>
DLPOLY_INLINE void finish_beads(PassArguments<Record>& a, typename Lanes::Advance& advance, Workspace<Record>& work,
                                int32_t begin, int32_t end) {
    if (a.bonded != nullptr) {
        add_bonded(a, work, begin, end);
    }
    if (!last && a.stage != Stage::advance) {
        if (a.stage == Stage::predict) {
            take_prediction(a, work, begin, end);
        } else if (a.stage == Stage::advance_held) {
            add_held(a, work, begin, end);
        } else {
            estimate_momenta(a, work, begin, end);
            return;
        }
    }
    if constexpr (last) {
        for (int32_t i = begin; i < end; ++i) {
            int64_t* out = a.impulses + 3 * static_cast<int64_t>(a.sorted[i].tag & id_mask);
            for (int axis = 0; axis < 3; ++axis) {
                out[axis] = work.impulse[4 * (i - begin) + axis];
            }
        }
    } else {
        const Record* const sorted = a.sorted;
        Record* const advanced = a.advanced;
        int32_t* const histogram = a.histogram;
        for (int32_t i = begin; i < end; ++i) {
            work.tag[i - begin] = sorted[i].tag & id_mask;
            const int32_t cell = advance(sorted[i], work.impulse + 4 * (i - begin), advanced[i]);
            keep_cell(a, i, cell);
            ++histogram[cell];
        }
        Lanes::bead_words(work.tag, work.word, end - begin, a.word_key);
        for (int32_t i = begin; i < end; ++i) {
            advanced[i].word = work.word[i - begin];
        }
        if (a.stage == Stage::predict) {
            add_prediction(a, begin, end);
        }
    }
}

// Beads begin..end of the block of cells first..last, pair after pair.
template <class Lanes, bool one_kind, bool drag, bool observe, bool last_step, class Record>
inline void direct_block(PassArguments<Record>& a, typename Lanes::Advance& advance, Workspace<Record>& work,
                         const int32_t* rows, int32_t first, int32_t last, double* observed) {
    const Candidates candidates = candidates_of(a, rows, first, last);
    const int32_t* start = a.row_start + static_cast<int64_t>(rows[0]) * a.cells_x;
    for (int32_t begin = start[first]; begin < start[last]; begin += most_beads) {
        const int32_t end = begin + most_beads < start[last] ? begin + most_beads : start[last];
        for (int32_t i = begin; i < end; ++i) {
            direct_bead<one_kind, drag, observe>(a, candidates, i, work.impulse + 4 * (i - begin), observed);
        }
        finish_beads<last_step, Lanes>(a, advance, work, begin, end);
    }
}

// Moves one bead after another and returns its new cell.
template <class Record>
struct ScalarAdvance {
    struct Advance {
        PassArguments<Record>& a;

        explicit Advance(PassArguments<Record>& arguments) : a(arguments) {}
        int32_t operator()(const Record& bead, const typename Record::Fixed* impulse, Record& out) const {
            advance_bead(a, bead, impulse, out);
            return cell_of(a, out);
        }
        static uint64_t overflow() { return 0; }  // advance_bead notes it in the arguments
    };
};

// Lanes of the plain path: no vectors, every block takes the direct way.
template <class Record>
struct PlainLanes : ScalarAdvance<Record> {
    static void bead_words(const uint32_t* ids, uint32_t* words, int32_t count, const uint32_t* key) {
        for (int32_t k = 0; k < count; ++k) {
            words[k] = bead_word(ids[k], key);
        }
    }
};

template <class Record, bool one_kind, bool drag, bool observe, bool last_step>
void plain_pass(PassArguments<Record>& a, int32_t first_place, int32_t last_place) {
    Workspace<Record>& work = *static_cast<Workspace<Record>*>(a.workspace);
    typename PlainLanes<Record>::Advance advance(a);
    for (int32_t place = first_place; place < last_place; ++place) {
        int32_t rows[9];
        neighbour_rows(a, place, rows);
        double* observed = observe ? a.observed + static_cast<int64_t>(place) * observed_numbers : nullptr;
        for (int32_t first = 0; first < a.cells_x; first += a.cells_a_block) {
            const int32_t last = first + a.cells_a_block < a.cells_x ? first + a.cells_a_block : a.cells_x;
            direct_block<PlainLanes<Record>, one_kind, drag, observe, last_step>(a, advance, work, rows, first, last,
                                                                                 observed);
        }
    }
}

}  // namespace dlpoly::fast::DLPOLY_SIMD
