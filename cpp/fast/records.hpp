// The records that the fast path sorts and streams: everything a pair needs of a bead, in integers.
//
// Positions are fixed-point fractions of the box edge, so that wrapping is integer overflow, a difference is the
// minimum image, and r_i − r_j is exactly −(r_j − r_i). Momenta are fixed-point too and a pair adds the same integer to
// one bead that it takes from the other: the total momentum never changes by a single bit, and sums do not depend on
// their order. Momenta are half a step behind positions (leapfrog), which is where drag and noise of mdvv need them.
#pragma once

#include <cstdint>

namespace dlpoly::fast {

// A bead's kind (species, and whether it is frozen) in the upper bits of the tag, its id in the lower ones.
inline constexpr std::uint32_t kind_shift = 28;
inline constexpr std::uint32_t id_mask = (1U << kind_shift) - 1U;
inline constexpr int most_kinds = 16;

struct alignas(32) MixedRecord {
    using Fixed = std::int32_t;
    using Arithmetic = float;
    static constexpr int position_bits = 32;  // of a position that carry information, from the top
    static constexpr int momentum_bits = 30;  // of a momentum in range, without its sign

    std::int32_t x, y, z;
    std::uint32_t word;  // this step's random word of the bead
    std::int32_t px, py, pz;
    std::uint32_t tag;
};

struct alignas(64) DoubleRecord {
    using Fixed = std::int64_t;
    using Arithmetic = double;
    static constexpr int position_bits = 48;  // so that conversion to double and back is the identity
    static constexpr int momentum_bits = 50;  // as above, also of differences and half impulses

    std::int64_t x, y, z;
    std::uint32_t word;
    std::uint32_t tag;
    std::int64_t px, py, pz;
    std::int32_t cell;  // after a step, until the records are sorted again
    std::uint32_t unused;
};

static_assert(sizeof(MixedRecord) == 32 && sizeof(DoubleRecord) == 64);

}  // namespace dlpoly::fast
