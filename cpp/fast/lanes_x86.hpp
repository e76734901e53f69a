// What the vector versions for x86-64 share: moving a bead with all three axes in one 128-bit register (SSE4.1).
#pragma once

#include <immintrin.h>

#include "fast/pass.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

// Counts the crossings of a bead. Bits of `negative`: before the step it was in the lower half, so it left downward.
inline void count_crossings(int32_t* images, uint32_t id, int crossings, int negative) {
    int32_t* image = images + 3 * static_cast<int64_t>(id);
    for (int axis = 0; axis < 3; ++axis) {
        if ((crossings >> axis & 1) != 0) {
            image[axis] += (negative >> axis & 1) != 0 ? -1 : 1;
        }
    }
}

// The same as advance_bead and cell_of of pass.hpp, three axes at a time.
struct MixedAdvance {
    struct Advance {
        explicit Advance(const PassArguments<MixedRecord>& a)
            : counts_xz(_mm_setr_epi32(a.cells_x, 0, a.rows_z, 0)),
              count_y(_mm_setr_epi32(a.rows_y, 0, 0, 0)),
              axes(_mm_setr_epi32(-1, -1, -1, 0)),
              out_of_range(_mm_setzero_si128()),
              drifts(a.drift),
              images(a.images),
              ranks(a.row_rank),
              rows_y(a.rows_y),
              cells_x(a.cells_x) {}

        DLPOLY_INLINE int32_t operator()(const MixedRecord& bead, const int32_t* impulse, MixedRecord& out) {
            const __m128i* from = reinterpret_cast<const __m128i*>(&bead);
            const __m128 drift = _mm_set1_ps(drifts[bead.tag >> kind_shift]);
            // Lane 3 holds the tag, which no impulse may change; frozen beads take none.
            const __m128i mobile = _mm_castps_si128(_mm_cmpneq_ps(drift, _mm_setzero_ps()));
            const __m128i kick =
                _mm_and_si128(_mm_and_si128(_mm_load_si128(reinterpret_cast<const __m128i*>(impulse)), axes), mobile);
            const __m128i momentum = _mm_add_epi32(_mm_load_si128(from + 1), kick);
            const __m128i step = _mm_and_si128(_mm_cvtps_epi32(_mm_mul_ps(_mm_cvtepi32_ps(momentum), drift)), axes);
            const __m128i before = _mm_load_si128(from);
            const __m128i after = _mm_add_epi32(before, step);
            _mm_store_si128(reinterpret_cast<__m128i*>(&out), after);
            _mm_store_si128(reinterpret_cast<__m128i*>(&out) + 1, momentum);

            // Signed overflow of a position is a crossing of the box's face; of a doubled momentum, the end of its
            // range.
            const __m128i crossed = _mm_and_si128(_mm_xor_si128(before, after), _mm_xor_si128(step, after));
            const int crossings = _mm_movemask_ps(_mm_castsi128_ps(crossed)) & 7;
            if (__builtin_expect(crossings != 0, 0)) {
                count_crossings(images, bead.tag & id_mask, crossings, _mm_movemask_ps(_mm_castsi128_ps(before)));
            }
            out_of_range = _mm_or_si128(out_of_range, _mm_xor_si128(momentum, _mm_add_epi32(momentum, momentum)));

            // Cells: upper halves of the products of positions, as unsigned fractions of the box, and counts.
            const __m128i xz = _mm_mul_epu32(after, counts_xz);
            const __m128i y = _mm_mul_epu32(_mm_srli_epi64(after, 32), count_y);
            const int32_t row = _mm_extract_epi32(xz, 3) * rows_y + _mm_extract_epi32(y, 1);
            return ranks[row] * cells_x + _mm_extract_epi32(xz, 1);
        }

        [[nodiscard]] uint64_t overflow() const {
            return static_cast<uint64_t>(_mm_movemask_ps(_mm_castsi128_ps(out_of_range)) & 7);
        }

      private:
        __m128i counts_xz, count_y;  // cells along the axes, in the lanes whose products are wanted
        __m128i axes;                // all bits of lanes 0 to 2
        __m128i out_of_range;
        const float* drifts;
        int32_t* images;
        const int32_t* ranks;
        int32_t rows_y, cells_x;
    };
};

}  // namespace dlpoly::fast::DLPOLY_SIMD
