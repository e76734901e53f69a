// The pass over all pairs with vectors; see pass.hpp for its phases and arguments.hpp for its numbers.
//
// `Lanes` hides the instruction set. It works on `width` pairs at a time and provides
//   types      Real, Fixed (a fixed-point number a lane), Sum (a running integer sum a lane), Word, Tag, Mask
//   loading    Neighbours load(records, offsets, accepted): records of the next `width` accepted candidates, transposed
//   search     accept(...): the candidates of a block that may be in range of a bead, as their numbers
//   words      bead_words(...): the beads' next random words
//   arithmetic the few operations used below
#pragma once

#include "fast/pass.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

// Copies the shadows of consecutive beads behind the `count` candidates that are there. Whole vectors are copied; what
// they write past the span is overwritten by the next one.
template <class Lanes, class Record>
DLPOLY_INLINE void append(const PassArguments<Record>& a, Workspace<Record>& work, Span span, int at) {
    const int length = span.end - span.begin;
    Lanes::copy_shadows(a, span.begin, work.x + at, work.y + at, work.z + at, work.offset + at);
    for (int k = Lanes::copy_width; __builtin_expect(k < length, 0); k += Lanes::copy_width) {
        Lanes::copy_shadows(a, span.begin + k, work.x + at + k, work.y + at + k, work.z + at + k, work.offset + at + k);
    }
}

// Brings the shadows of all candidates of the block of cells first..last next to each other. Returns how many there are
// and where the block's first bead stands among them, or −1 when they are too many for the buffers.
template <class Lanes, class Record>
DLPOLY_INLINE int collect(const PassArguments<Record>& a, Workspace<Record>& work, const int32_t* rows, int32_t first,
                          int32_t last, int block, int* self) {
    const int at = block * candidate_stride;
    int count = 0;
    if (__builtin_expect(first > 0 && last < a.cells_x, 1)) {  // nine rows, none of which wraps
        for (int k = 0; k < 9; ++k) {
            const int32_t* start = a.row_start + static_cast<int64_t>(rows[k]) * a.cells_x;
            const Span span{start[first - 1], start[last + 1]};
            if (__builtin_expect(count + (span.end - span.begin) > most_candidates, 0)) {
                return -1;
            }
            append<Lanes>(a, work, span, at + count);
            count += span.end - span.begin;
        }
        const int32_t* own = a.row_start + static_cast<int64_t>(rows[0]) * a.cells_x;  // the first row
        *self = own[first] - own[first - 1];
        return count;
    }
    const int32_t first_bead = a.row_start[static_cast<int64_t>(rows[0]) * a.cells_x + first];
    const Candidates candidates = candidates_of(a, rows, first, last);
    for (int s = 0; s < candidates.count; ++s) {
        const Span span = candidates.spans[s];
        if (count + (span.end - span.begin) > most_candidates) {
            return -1;
        }
        if (first_bead >= span.begin && first_bead < span.end) {
            *self = count + (first_bead - span.begin);
        }
        append<Lanes>(a, work, span, at + count);
        count += span.end - span.begin;
    }
    return count;
}

// What is the same for every bead of a pass, in registers.
template <class Lanes, bool one_kind>
struct Constants {
    typename Lanes::Real one, metric_x, metric_y, metric_z;
    typename Lanes::Pairs table;  // of the only kind; with several kinds, each bead takes its own

    template <class Record>
    DLPOLY_INLINE explicit Constants(const PassArguments<Record>& a)
        : one(Lanes::all(1)),
          metric_x(Lanes::all(a.metric_x)),
          metric_y(Lanes::all(a.metric_y)),
          metric_z(Lanes::all(a.metric_z)),
          table(Lanes::only_pair(a.rows[0], a.inverse_mass[0])) {}
};

template <bool first, class A, class B>
DLPOLY_INLINE const auto& choose(const A& a, const B& b) {
    if constexpr (first) {
        return a;
    } else {
        return b;
    }
}

// Impulse of all accepted neighbours on one bead.
template <class Lanes, bool one_kind, bool drag, bool observe, class Record>
DLPOLY_INLINE void sum_pairs(const Constants<Lanes, one_kind>& constants, const PassArguments<Record>& a,
                             const Record& bead, const uint32_t* offsets, const uint8_t* accepted, int count,
                             typename Record::Fixed* impulse, double* observed) {
    using Real = typename Lanes::Real;
    using Sum = typename Lanes::Sum;
    const uint32_t kind = one_kind ? 0 : bead.tag >> kind_shift;
    const auto self = Lanes::broadcast(bead);
    // By reference where there is one kind: a copy of the table would be spilled to the stack for every bead.
    const auto own_table = [&] {
        if constexpr (one_kind) {
            return 0;
        } else {
            return Lanes::tables(a.rows[kind], a.inverse_mass);
        }
    }();
    const Real one = constants.one;
    const Real metric_x = constants.metric_x;
    const Real metric_y = constants.metric_y;
    const Real metric_z = constants.metric_z;
    Real velocity_x, velocity_y, velocity_z;
    if constexpr (drag && !one_kind) {
        const Real inverse_mass = Lanes::all(a.inverse_mass[kind]);
        velocity_x = Lanes::multiply(Lanes::real(self.px), inverse_mass);
        velocity_y = Lanes::multiply(Lanes::real(self.py), inverse_mass);
        velocity_z = Lanes::multiply(Lanes::real(self.pz), inverse_mass);
    }
    Sum sum_x = Lanes::no_sum(), sum_y = Lanes::no_sum(), sum_z = Lanes::no_sum();
    Real seen[observe ? observed_numbers : 1];
    if constexpr (observe) {
        for (Real& number : seen) {
            number = Lanes::all(0);
        }
    }
    for (int k = 0; k < count; k += Lanes::width) {
        const auto other = Lanes::load(a.sorted, offsets, accepted + k);
        const Real dx = Lanes::difference(self.x, other.x);
        const Real dy = Lanes::difference(self.y, other.y);
        const Real dz = Lanes::difference(self.z, other.z);
        const Real ex = Lanes::multiply(metric_x, dx);
        const Real ey = Lanes::multiply(metric_y, dy);
        const Real ez = Lanes::multiply(metric_z, dz);
        const Real distance_squared = Lanes::multiply_add(ex, dx, Lanes::multiply_add(ey, dy, Lanes::multiply(ez, dz)));
        const Real inverse = Lanes::inverse_root(distance_squared);
        const Real distance = Lanes::multiply(distance_squared, inverse);
        const auto looked_up = [&] {
            if constexpr (one_kind) {
                return 0;
            } else {
                return Lanes::template look_up<drag, observe>(own_table, other.tag);
            }
        }();
        const auto& pair = choose<one_kind>(constants.table, looked_up);
        const Real w = Lanes::negative_multiply_add(distance, pair.inverse_cutoff, one);
        const auto inside = Lanes::positive(w, count - k);
        const Real slope = Lanes::multiply(w, inverse);
        Real strength = pair.repulsion;
        Real drag_part, noise_part;
        if constexpr (drag) {
            Real vx, vy, vz;
            if constexpr (one_kind) {
                vx = Lanes::difference(self.px, other.px);
                vy = Lanes::difference(self.py, other.py);
                vz = Lanes::difference(self.pz, other.pz);
            } else {
                // Both products are rounded: a fused one would make the difference depend on which bead is asked.
                vx = Lanes::subtract(velocity_x, Lanes::multiply(Lanes::real(other.px), pair.inverse_mass));
                vy = Lanes::subtract(velocity_y, Lanes::multiply(Lanes::real(other.py), pair.inverse_mass));
                vz = Lanes::subtract(velocity_z, Lanes::multiply(Lanes::real(other.pz), pair.inverse_mass));
            }
            const Real approach = Lanes::multiply_add(ex, vx, Lanes::multiply_add(ey, vy, Lanes::multiply(ez, vz)));
            const Real zeta = Lanes::noise(self.word, other.word);
            const Real damping = Lanes::multiply(Lanes::multiply(pair.drag, w), Lanes::multiply(approach, inverse));
            if constexpr (observe) {
                drag_part = Lanes::subtract(Lanes::all(0), damping);
                noise_part = Lanes::multiply(pair.noise, zeta);
            }
            strength = Lanes::subtract(Lanes::multiply_add(pair.noise, zeta, pair.repulsion), damping);
        }
        const Real factor = Lanes::multiply_where(inside, strength, slope);
        sum_x = Lanes::add_nearest(sum_x, Lanes::multiply(factor, dx));
        sum_y = Lanes::add_nearest(sum_y, Lanes::multiply(factor, dy));
        sum_z = Lanes::add_nearest(sum_z, Lanes::multiply(factor, dz));
        if constexpr (observe) {
            seen[0] = Lanes::add(seen[0], Lanes::multiply_where(inside, pair.energy, Lanes::multiply(w, w)));
            const Real products[6] = {Lanes::multiply(dx, dx), Lanes::multiply(dy, dy), Lanes::multiply(dz, dz),
                                      Lanes::multiply(dx, dy), Lanes::multiply(dx, dz), Lanes::multiply(dy, dz)};
            const Real part = Lanes::multiply_where(inside, pair.repulsion, slope);
            for (int n = 0; n < 6; ++n) {
                seen[1 + n] = Lanes::multiply_add(part, products[n], seen[1 + n]);
            }
            if constexpr (drag) {
                const Real damped = Lanes::multiply_where(inside, drag_part, slope);
                const Real shaken = Lanes::multiply_where(inside, noise_part, slope);
                for (int n = 0; n < 6; ++n) {
                    seen[7 + n] = Lanes::multiply_add(damped, products[n], seen[7 + n]);
                    seen[13 + n] = Lanes::multiply_add(shaken, products[n], seen[13 + n]);
                }
            }
        }
    }
    Lanes::store_sums(sum_x, sum_y, sum_z, impulse);
    if constexpr (observe) {
        for (int n = 0; n < observed_numbers; ++n) {
            observed[n] += Lanes::total(seen[n]);
        }
    }
}

template <class Lanes, class Record, bool one_kind, bool drag, bool observe, bool last_step>
void vector_pass(PassArguments<Record>& a, int32_t first_place, int32_t last_place) {
    Workspace<Record>& work = *static_cast<Workspace<Record>*>(a.workspace);
    const auto search = Lanes::search_tables(a);
    const Constants<Lanes, one_kind> constants(a);
    typename Lanes::Advance advance(a);
    for (int32_t place = first_place; place < last_place; ++place) {
        int32_t rows[9];
        neighbour_rows(a, place, rows);
        double* observed = observe ? a.observed + static_cast<int64_t>(place) * observed_numbers : nullptr;
        const int32_t* start = a.row_start + static_cast<int64_t>(place) * a.cells_x;
        int32_t first = 0;
        while (first < a.cells_x) {
            // A piece: as many blocks as the buffers hold.
            int blocks = 0;
            int32_t block_first[blocks_a_piece + 1];
            int block_count[blocks_a_piece], block_self[blocks_a_piece];
            const int32_t begin = start[first];
            int32_t cell = first;
            block_first[0] = first;
            while (blocks < blocks_a_piece && cell < a.cells_x) {
                const int32_t next = cell + a.cells_a_block < a.cells_x ? cell + a.cells_a_block : a.cells_x;
                if (start[next] - begin > most_beads) {
                    break;
                }
                block_self[blocks] = 0;
                block_count[blocks] = collect<Lanes>(a, work, rows, cell, next, blocks, &block_self[blocks]);
                block_first[++blocks] = next;
                cell = next;
            }
            if (blocks == 0) {
                const int32_t next = cell + a.cells_a_block < a.cells_x ? cell + a.cells_a_block : a.cells_x;
                direct_block<Lanes, one_kind, drag, observe, last_step>(a, advance, work, rows, cell, next, observed);
                first = next;
                continue;
            }
            for (int b = 0; b < blocks; ++b) {
                const int at = b * candidate_stride;
                int self = block_self[b];
                for (int32_t i = start[block_first[b]]; i < start[block_first[b + 1]]; ++i, ++self) {
                    const int n = i - begin;
                    work.accepted_count[n] =
                        block_count[b] < 0 ? -1
                                           : Lanes::accept(search, a, i, work.x + at, work.y + at, work.z + at,
                                                           block_count[b], self, work.accepted + n * accepted_stride);
                }
            }
            for (int b = 0; b < blocks; ++b) {
                for (int32_t i = start[block_first[b]]; i < start[block_first[b + 1]]; ++i) {
                    const int n = i - begin;
                    if (__builtin_expect(work.accepted_count[n] < 0, 0)) {
                        const Candidates candidates = candidates_of(a, rows, block_first[b], block_first[b + 1]);
                        direct_bead<one_kind, drag, observe>(a, candidates, i, work.impulse + 4 * n, observed);
                    } else {
                        sum_pairs<Lanes, one_kind, drag, observe>(
                            constants, a, a.sorted[i], work.offset + b * candidate_stride,
                            work.accepted + n * accepted_stride, work.accepted_count[n], work.impulse + 4 * n,
                            observed);
                    }
                }
            }
            finish_beads<last_step, Lanes>(a, advance, work, begin, start[cell]);
            first = cell;
        }
    }
    a.overflow |= advance.overflow();
}

}  // namespace dlpoly::fast::DLPOLY_SIMD
