// Scalar arithmetic of the fast path, apart for every instruction set (see pass.hpp for why).
#pragma once

#include <math.h>
#include <stdint.h>

#include "core/bead_words.hpp"
#include "fast/arguments.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

template <class Fixed>
struct UnsignedOf;
template <>
struct UnsignedOf<int32_t> {
    using type = uint32_t;
};
template <>
struct UnsignedOf<int64_t> {
    using type = uint64_t;
};

// Differences and sums of fixed-point positions wrap: that is the minimum image, and must not be undefined behaviour.
// Sums of momenta wrap where a run leaves their range, before the run is stopped.
template <class Fixed>
inline Fixed wrapped_difference(Fixed a, Fixed b) {
    using Unsigned = typename UnsignedOf<Fixed>::type;
    return static_cast<Fixed>(static_cast<Unsigned>(a) - static_cast<Unsigned>(b));
}
template <class Fixed>
inline Fixed wrapped_sum(Fixed a, Fixed b) {
    using Unsigned = typename UnsignedOf<Fixed>::type;
    return static_cast<Fixed>(static_cast<Unsigned>(a) + static_cast<Unsigned>(b));
}
// A step of several boxes, which only momenta out of range make, wraps too.
template <class Fixed>
inline Fixed shifted_up(int64_t a, int bits) {
    using Unsigned = typename UnsignedOf<Fixed>::type;
    return static_cast<Fixed>(static_cast<Unsigned>(a) << bits);
}

inline float square_root(float x) { return sqrtf(x); }
inline double square_root(double x) { return sqrt(x); }
inline int64_t nearest(float x) { return lrintf(x); }
inline int64_t nearest(double x) { return llrint(x); }

// Which of `count` equal cells a fixed-point position lies in; the position is an unsigned fraction of the box.
inline int32_t cell_index(int32_t position, int32_t count) {
    return static_cast<int32_t>(
        (static_cast<uint64_t>(static_cast<uint32_t>(position)) * static_cast<uint32_t>(count)) >> 32);
}
inline int32_t cell_index(int64_t position, int32_t count) {
    // The upper 64 bits of a 96-bit product, from two halves.
    const uint64_t bits = static_cast<uint64_t>(position);
    const uint64_t low = (bits & 0xFFFFFFFFU) * static_cast<uint32_t>(count);
    const uint64_t high = (bits >> 32) * static_cast<uint32_t>(count) + (low >> 32);
    return static_cast<int32_t>(high >> 32);
}

template <class Record>
inline int32_t cell_of(const PassArguments<Record>& a, const Record& bead) {
    const int32_t row = cell_index(bead.z, a.rows_z) * a.rows_y + cell_index(bead.y, a.rows_y);
    return a.row_rank[row] * a.cells_x + cell_index(bead.x, a.cells_x);
}

// The cell of an advanced bead is kept until the beads are sorted: in the record where it has room, else beside it.
inline void keep_cell(const PassArguments<DoubleRecord>& a, int32_t i, int32_t cell) { a.advanced[i].cell = cell; }
inline void keep_cell(const PassArguments<MixedRecord>& a, int32_t i, int32_t cell) { a.cell_of[i] = cell; }
inline int32_t kept_cell(const int32_t*, const DoubleRecord* advanced, int32_t i) { return advanced[i].cell; }
inline int32_t kept_cell(const int32_t* cell_of, const MixedRecord*, int32_t i) { return cell_of[i]; }

}  // namespace dlpoly::fast::DLPOLY_SIMD
