// The phases for AVX-512; chosen at run time only where the processor has it. What needs compression or transposition
// is written out, the rest are the common loops.
#include "forces/pair_phases.hpp"

#ifdef DLPOLY_HAS_AVX512

#include <immintrin.h>

#define DLPOLY_SIMD avx512
#include "forces/pair_phases_loops.hpp"

namespace dlpoly {

namespace avx512 {

// The four words of eight records, transposed.
struct Columns {
    __m512d x, y, z, w;
};

static inline __m512d two_records(const double* low, const double* high) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(low)), _mm256_load_pd(high), 1);
}

// Record index[stride · k] becomes lane k.
template <class Record, size_t stride>
static inline Columns load_records(const Record* records, const uint32_t* index) {
    const auto at = [&](size_t k) { return &records[index[stride * k]].x; };
    const __m512d a = two_records(at(0), at(2));
    const __m512d b = two_records(at(1), at(3));
    const __m512d c = two_records(at(4), at(6));
    const __m512d d = two_records(at(5), at(7));
    const __m512d xz_low = _mm512_unpacklo_pd(a, b);
    const __m512d yw_low = _mm512_unpackhi_pd(a, b);
    const __m512d xz_high = _mm512_unpacklo_pd(c, d);
    const __m512d yw_high = _mm512_unpackhi_pd(c, d);
    return {_mm512_shuffle_f64x2(xz_low, xz_high, 0x88), _mm512_shuffle_f64x2(yw_low, yw_high, 0x88),
            _mm512_shuffle_f64x2(xz_low, xz_high, 0xdd), _mm512_shuffle_f64x2(yw_low, yw_high, 0xdd)};
}

static inline __m512d length_squared(__m512d dx, __m512d dy, __m512d dz) {
    return _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dy, dy)), _mm512_mul_pd(dz, dz));
}

static ListEntry* vector_search(const SearchArguments& a, uint32_t bead, const CandidateRange* ranges, size_t count,
                                ListEntry* out) {
    // Copies, because the compiler must suppose that storing entries changes the arguments.
    const double* const all_x = a.x;
    const double* const all_y = a.y;
    const double* const all_z = a.z;
    const __m512d x = _mm512_set1_pd(all_x[bead]);
    const __m512d y = _mm512_set1_pd(all_y[bead]);
    const __m512d z = _mm512_set1_pd(all_z[bead]);
    const __m512d limit = _mm512_set1_pd(a.limit_squared);
    const __m512i ascending = _mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0);
    for (size_t r = 0; r < count; ++r) {
        const CandidateRange range = ranges[r];
        const ShiftRecord& shift = a.shifts[range.image];
        const __m512d sx = _mm512_set1_pd(shift.x);
        const __m512d sy = _mm512_set1_pd(shift.y);
        const __m512d sz = _mm512_set1_pd(shift.z);
        const __m512i image = _mm512_set1_epi64(static_cast<int64_t>(uint64_t{range.image} << 32));
        for (uint32_t first = range.begin; first < range.end; first += batch_lanes) {
            const uint32_t left = range.end - first;
            const auto present = static_cast<__mmask8>(left >= batch_lanes ? 0xffU : (1U << left) - 1U);
            const __m512d dx = _mm512_sub_pd(_mm512_sub_pd(x, _mm512_loadu_pd(all_x + first)), sx);
            const __m512d dy = _mm512_sub_pd(_mm512_sub_pd(y, _mm512_loadu_pd(all_y + first)), sy);
            const __m512d dz = _mm512_sub_pd(_mm512_sub_pd(z, _mm512_loadu_pd(all_z + first)), sz);
            const __mmask8 near = _mm512_mask_cmp_pd_mask(present, length_squared(dx, dy, dz), limit, _CMP_LT_OQ);
            const __m512i entries =
                _mm512_or_si512(image, _mm512_add_epi64(ascending, _mm512_set1_epi64(static_cast<int64_t>(first))));
            _mm512_storeu_si512(out, _mm512_maskz_compress_epi64(near, entries));
            out += __builtin_popcount(near);
        }
    }
    return out;
}

static inline bool vector_filter(FilterArguments& a, PairBatch& batch) {
    const __m512d reach = _mm512_set1_pd(batch.reach_squared);
    const __m512i zero = _mm512_set1_epi64(a.zero);
    return walk_segments(a, batch, [&](uint32_t bead, const BeadRecord& own, const ListEntry* entries, size_t size) {
        _mm_prefetch(reinterpret_cast<const char*>(entries + 256), _MM_HINT_T0);
        const Columns other = load_records<BeadRecord, 2>(a.beads, &entries->bead);
        const __m512i both = _mm512_loadu_si512(entries);
        const __m512i image =
            _mm512_add_epi64(_mm512_srli_epi64(both, 32),
                             _mm512_sub_epi64(_mm512_castpd_si512(other.w), _mm512_set1_epi64(own.lattice)));
        __m512d dx = _mm512_sub_pd(_mm512_set1_pd(own.x), other.x);
        __m512d dy = _mm512_sub_pd(_mm512_set1_pd(own.y), other.y);
        __m512d dz = _mm512_sub_pd(_mm512_set1_pd(own.z), other.z);
        unsigned across = _mm512_cmpneq_epi64_mask(image, zero);
        if (across != 0) {
            // Neighbours come in ranges of one image: a few at most meet in one vector.
            alignas(64) int64_t images[batch_lanes];
            _mm512_store_si512(images, image);
            while (across != 0) {
                const int64_t number = images[__builtin_ctz(across)];
                const ShiftRecord& shift = a.shifts[number];
                const __mmask8 same = _mm512_cmpeq_epi64_mask(image, _mm512_set1_epi64(number));
                dx = _mm512_mask_sub_pd(dx, same, dx, _mm512_set1_pd(shift.x));
                dy = _mm512_mask_sub_pd(dy, same, dy, _mm512_set1_pd(shift.y));
                dz = _mm512_mask_sub_pd(dz, same, dz, _mm512_set1_pd(shift.z));
                across &= ~static_cast<unsigned>(same);
            }
        }
        const __m512d squared = length_squared(dx, dy, dz);
        const __mmask8 near = _mm512_cmp_pd_mask(squared, reach, _CMP_LT_OQ);
        _mm512_storeu_pd(batch.dx.values + size, _mm512_maskz_compress_pd(near, dx));
        _mm512_storeu_pd(batch.dy.values + size, _mm512_maskz_compress_pd(near, dy));
        _mm512_storeu_pd(batch.dz.values + size, _mm512_maskz_compress_pd(near, dz));
        _mm512_storeu_pd(batch.distance_squared.values + size, _mm512_maskz_compress_pd(near, squared));
        const auto store = [size](BatchArray<uint32_t>& array, __m256i values) {
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(array.values + size), values);
        };
        store(batch.i, _mm256_set1_epi32(static_cast<int32_t>(bead)));
        store(batch.j, _mm512_cvtepi64_epi32(_mm512_maskz_compress_epi64(near, both)));
        if (a.images) {
            store(batch.image, _mm512_cvtepi64_epi32(_mm512_maskz_compress_epi64(near, image)));
        }
        return size + static_cast<size_t>(__builtin_popcount(near));
    });
}

static void vector_motion(const MotionArguments& a, const PairBatch& batch, BatchResult& result) {
    alignas(64) double projection[batch_capacity + batch_lanes];
    alignas(64) int32_t words[batch_capacity + batch_lanes];
    for (size_t k = 0; k < batch.size; k += batch_lanes) {
        const Columns i = load_records<MotionRecord, 1>(a.beads, batch.i.values + k);
        const Columns j = load_records<MotionRecord, 1>(a.beads, batch.j.values + k);
        const __m512d x = _mm512_mul_pd(_mm512_load_pd(batch.dx.values + k), _mm512_sub_pd(i.x, j.x));
        const __m512d y = _mm512_mul_pd(_mm512_load_pd(batch.dy.values + k), _mm512_sub_pd(i.y, j.y));
        const __m512d z = _mm512_mul_pd(_mm512_load_pd(batch.dz.values + k), _mm512_sub_pd(i.z, j.z));
        _mm512_store_pd(projection + k, _mm512_add_pd(_mm512_add_pd(x, y), z));
        const __m512i sum = _mm512_add_epi64(_mm512_castpd_si512(i.w), _mm512_castpd_si512(j.w));
        _mm256_store_si256(reinterpret_cast<__m256i*>(words + k), _mm512_cvtepi64_epi32(sum));
    }
    const size_t count = whole_lanes(batch.size);
    if (a.image_codes == nullptr) {
        for (size_t k = 0; k < count; ++k) {
            words[k] = mix_words(static_cast<uint32_t>(words[k]), 0);
        }
    } else {
        for (size_t k = 0; k < count; ++k) {
            words[k] = mix_words(static_cast<uint32_t>(words[k]), 0, image_code(a, batch, k));
        }
    }
    motion_factors(a, batch, projection, words, result);
}

static bool vector_round(const PairBatch& batch, BatchResult& result, bool motion, double scale) {
    const __m512d factors = _mm512_set1_pd(scale);
    const __m512d limit = _mm512_set1_pd(grid_reach);
    const __m512i nothing = _mm512_setzero_si512();
    unsigned fits = 0xffU;
    for (size_t k = 0; k < batch.size; k += batch_lanes) {
        __m512d factor = _mm512_load_pd(result.conservative.values + k);
        if (motion) {
            factor = _mm512_add_pd(factor, _mm512_load_pd(result.drag.values + k));
            factor = _mm512_add_pd(factor, _mm512_load_pd(result.noise.values + k));
        }
        const auto part = [&](const double* d) {
            return _mm512_mul_pd(_mm512_mul_pd(factor, _mm512_load_pd(d + k)), factors);
        };
        const __m512d x = part(batch.dx.values);
        const __m512d y = part(batch.dy.values);
        const __m512d z = part(batch.dz.values);
        const auto below = [&](__m512d v) -> unsigned {
            return _mm512_cmp_pd_mask(_mm512_abs_pd(v), limit, _CMP_LT_OQ);
        };
        fits &= below(x) & below(y) & below(z);
        const __m512i grid_x = _mm512_cvtpd_epi64(x);
        const __m512i grid_y = _mm512_cvtpd_epi64(y);
        const __m512i grid_z = _mm512_cvtpd_epi64(z);
        const __m512i xy_even = _mm512_unpacklo_epi64(grid_x, grid_y);  // x0 y0, x2 y2, x4 y4, x6 y6
        const __m512i xy_odd = _mm512_unpackhi_epi64(grid_x, grid_y);
        const __m512i z_even = _mm512_unpacklo_epi64(grid_z, nothing);
        const __m512i z_odd = _mm512_unpackhi_epi64(grid_z, nothing);
        const auto store = [&](size_t at, __m512i xy, __m512i zw, auto take) {
            const __m256i low = take(xy);
            const __m256i high = take(zw);
            auto* out = reinterpret_cast<__m256i*>(result.force.values + k + at);
            _mm256_store_si256(out, _mm256_permute2x128_si256(low, high, 0x20));
            _mm256_store_si256(out + 2, _mm256_permute2x128_si256(low, high, 0x31));
        };
        const auto lower = [](__m512i v) { return _mm512_castsi512_si256(v); };
        const auto upper = [](__m512i v) { return _mm512_extracti64x4_epi64(v, 1); };
        store(0, xy_even, z_even, lower);
        store(1, xy_odd, z_odd, lower);
        store(4, xy_even, z_even, upper);
        store(5, xy_odd, z_odd, upper);
    }
    return fits == 0xffU;
}

static void vector_add(const PairBatch& batch, const BatchResult& result, GridForce* sums) {
    for (size_t r = 0; r < batch.runs; ++r) {
        const PairRun run = batch.run.values[r];
        __m256i own = _mm256_setzero_si256();
        for (uint32_t k = run.begin; k < run.end; ++k) {
            const __m256i force = _mm256_load_si256(reinterpret_cast<const __m256i*>(result.force.values + k));
            auto* other = reinterpret_cast<__m256i*>(sums + batch.j.values[k]);
            own = _mm256_add_epi64(own, force);
            _mm256_store_si256(other, _mm256_sub_epi64(_mm256_load_si256(other), force));
        }
        auto* sum = reinterpret_cast<__m256i*>(sums + run.bead);
        _mm256_store_si256(sum, _mm256_add_epi64(_mm256_load_si256(sum), own));
    }
}

}  // namespace avx512

const Phases* avx512_phases() {
    static constexpr Phases phases{"avx512",
                                   &avx512::vector_search,
                                   &avx512::vector_filter,
                                   &avx512::vector_motion,
                                   &avx512::vector_round,
                                   &avx512::vector_add,
                                   &avx512::observe};
    const bool supported = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
                           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
    return supported ? &phases : nullptr;
}

}  // namespace dlpoly

#else

namespace dlpoly {

const Phases* avx512_phases() { return nullptr; }

}  // namespace dlpoly

#endif
