// Lanes of AVX-512 (F, BW, DQ, VL, VBMI, VBMI2: Ice Lake, Zen 4 and later): 16 pairs in single, 8 in double precision.
#pragma once

#include <immintrin.h>

#include "fast/lanes_x86.hpp"
#include "fast/pass.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

// Parts that do not depend on the precision: the 8-bit search and the random words.
template <class Record>
struct CommonLanes {
    static constexpr int copy_width = 32;

    static DLPOLY_INLINE void copy_shadows(const PassArguments<Record>& a, int32_t from, uint8_t* x, uint8_t* y,
                                           uint8_t* z, uint32_t* offset) {
        const auto copy = [from](const uint8_t* source, uint8_t* target) {
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(target),
                                _mm256_loadu_si256(reinterpret_cast<const __m256i*>(source + from)));
        };
        copy(a.shadow_x, x);
        copy(a.shadow_y, y);
        copy(a.shadow_z, z);
        constexpr int size = sizeof(Record);
        const __m512i ramp = _mm512_mullo_epi32(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
                                                _mm512_set1_epi32(size));
        const __m512i first =
            _mm512_add_epi32(_mm512_set1_epi32(static_cast<int>(static_cast<uint32_t>(from) * size)), ramp);
        _mm512_storeu_si512(offset, first);
        _mm512_storeu_si512(offset + 16, _mm512_add_epi32(first, _mm512_set1_epi32(16 * size)));
    }

    struct SearchTables {
        __m512i x_low, x_high, y_low, y_high, z_low, z_high, threshold;
    };

    static DLPOLY_INLINE SearchTables search_tables(const PassArguments<Record>& a) {
        const auto half = [](const uint8_t* table) { return _mm512_loadu_si512(table); };
        return {half(a.distance_x),
                half(a.distance_x + 64),
                half(a.distance_y),
                half(a.distance_y + 64),
                half(a.distance_z),
                half(a.distance_z + 64),
                _mm512_set1_epi8(static_cast<char>(a.threshold))};
    }

    // Which of 64 candidates may be in range: shadow distances, their squares from the tables, saturating sums.
    static DLPOLY_INLINE uint64_t near(const SearchTables& t, const uint8_t* x, const uint8_t* y, const uint8_t* z,
                                       __m512i own_x, __m512i own_y, __m512i own_z) {
        const auto square = [](const uint8_t* other, __m512i own, __m512i low, __m512i high) {
            const __m512i apart = _mm512_abs_epi8(_mm512_sub_epi8(_mm512_loadu_si512(other), own));
            return _mm512_permutex2var_epi8(low, apart, high);
        };
        const __m512i sum =
            _mm512_adds_epu8(_mm512_adds_epu8(square(x, own_x, t.x_low, t.x_high), square(y, own_y, t.y_low, t.y_high)),
                             square(z, own_z, t.z_low, t.z_high));
        return _cvtmask64_u64(_mm512_cmple_epu8_mask(sum, t.threshold));
    }

    // Writes the numbers of the candidates that may be in range of bead i, which is number `self` itself.
    // Returns how many, or −1 when they are more than the list holds.
    static DLPOLY_INLINE int accept(const SearchTables& t, const PassArguments<Record>& a, int32_t i, const uint8_t* x,
                                    const uint8_t* y, const uint8_t* z, int count, int self, uint8_t* accepted) {
        const __m512i own_x = _mm512_set1_epi8(static_cast<char>(a.shadow_x[i]));
        const __m512i own_y = _mm512_set1_epi8(static_cast<char>(a.shadow_y[i]));
        const __m512i own_z = _mm512_set1_epi8(static_cast<char>(a.shadow_z[i]));
        const __m512i numbers = _mm512_loadu_si512(byte_numbers);
        if (__builtin_expect(count <= 128 && self < 64, 1)) {
            const uint64_t first =
                _bzhi_u64(near(t, x, y, z, own_x, own_y, own_z), static_cast<unsigned>(count)) & ~(uint64_t{1} << self);
            const uint64_t second = _bzhi_u64(near(t, x + 64, y + 64, z + 64, own_x, own_y, own_z),
                                              static_cast<unsigned>(count < 64 ? 0 : count - 64));
            const int in_first = __builtin_popcountll(first);
            _mm512_storeu_si512(accepted, _mm512_maskz_compress_epi8(_cvtu64_mask64(first), numbers));
            const int found = in_first + __builtin_popcountll(second);
            const __m512i later = _mm512_or_si512(numbers, _mm512_set1_epi8(64));
            _mm512_storeu_si512(accepted + in_first, _mm512_maskz_compress_epi8(_cvtu64_mask64(second), later));
            return found > most_accepted ? -1 : found;
        }
        int found = 0;
        for (int k = 0; k < count; k += 64) {
            const int left = count - k;
            uint64_t mask = near(t, x + k, y + k, z + k, own_x, own_y, own_z);
            mask &= left >= 64 ? ~uint64_t{0} : (uint64_t{1} << left) - 1;
            if (self >= k && self < k + 64) {
                mask &= ~(uint64_t{1} << (self - k));
            }
            // A whole vector is stored: what it writes past this bead's list, the next bead overwrites.
            if (found > most_accepted) {
                return -1;
            }
            _mm512_storeu_si512(
                accepted + found,
                _mm512_maskz_compress_epi8(_cvtu64_mask64(mask),
                                           _mm512_add_epi8(numbers, _mm512_set1_epi8(static_cast<char>(k)))));
            found += __builtin_popcountll(mask);
        }
        return found > most_accepted ? -1 : found;
    }

    // Philox2x32-10 of eight ids at a time; see core/bead_words.hpp.
    static DLPOLY_INLINE void bead_words(const uint32_t* ids, uint32_t* words, int32_t count, const uint32_t* key) {
        const __m512i multiplier = _mm512_set1_epi64(0xD256D193);
        const __m512i high_mask = _mm512_set1_epi64(static_cast<int64_t>(0xFFFFFFFF00000000ULL));
        for (int32_t k = 0; k < count; k += 8) {
            __m512i low =
                _mm512_cvtepu32_epi64(_mm256_xor_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(ids + k)),
                                                       _mm256_set1_epi32(static_cast<int>(key[1]))));
            __m512i high = _mm512_set1_epi64(static_cast<int64_t>(key[2]));
            uint32_t round_key = key[0];
            for (int round = 0; round < 10; ++round) {
                const __m512i product = _mm512_mul_epu32(multiplier, low);
                low = _mm512_xor_si512(_mm512_srli_epi64(product, 32),
                                       _mm512_xor_si512(_mm512_set1_epi64(static_cast<int64_t>(round_key)), high));
                high = _mm512_andnot_si512(high_mask, product);
                round_key += 0x9E3779B9U;
            }
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(words + k), _mm512_cvtepi64_epi32(low));
        }
    }

    alignas(64) static constexpr uint8_t byte_numbers[64] = {
        0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
        22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 43,
        44, 45, 46, 47, 48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63};
};

struct MixedLanes : CommonLanes<MixedRecord>, MixedAdvance {
    static constexpr int width = 16;
    using Real = __m512;
    using Fixed = __m512i;
    using Sum = __m512i;
    using Mask = __mmask16;

    struct Beads {
        __m512i x, y, z, word, px, py, pz, tag;
    };

    static DLPOLY_INLINE Beads broadcast(const MixedRecord& r) {
        const auto all_of = [](auto v) { return _mm512_set1_epi32(static_cast<int>(v)); };
        return {all_of(r.x),  all_of(r.y),  all_of(r.z),  all_of(r.word),
                all_of(r.px), all_of(r.py), all_of(r.pz), all_of(r.tag)};
    }

    // 16 records of eight 32-bit numbers, turned into eight vectors. Plain loads and shuffles: hardware gathers are
    // slower.
    static DLPOLY_INLINE Beads load(const MixedRecord* records, const uint32_t* offsets, const uint8_t* accepted) {
        const char* base = reinterpret_cast<const char*>(records);
        const auto record = [&](int lane) {
            return _mm256_load_ps(reinterpret_cast<const float*>(base + offsets[accepted[lane]]));
        };
        // Rows hold records (lane, lane + 4): four numbers of position in the first half of each, of momentum in the
        // second.
        const auto two = [&](int lane) {
            return _mm512_insertf32x8(_mm512_castps256_ps512(record(lane)), record(lane + 4), 1);
        };
        const Quarter low = transpose(two(0), two(1), two(2), two(3));
        const Quarter high = transpose(two(8), two(9), two(10), two(11));
        const auto positions = [](__m512 a, __m512 b) { return _mm512_castps_si512(_mm512_shuffle_f32x4(a, b, 0x88)); };
        const auto momenta = [](__m512 a, __m512 b) { return _mm512_castps_si512(_mm512_shuffle_f32x4(a, b, 0xDD)); };
        return {positions(low.first, high.first), positions(low.second, high.second),
                positions(low.third, high.third), positions(low.fourth, high.fourth),
                momenta(low.first, high.first),   momenta(low.second, high.second),
                momenta(low.third, high.third),   momenta(low.fourth, high.fourth)};
    }

    static DLPOLY_INLINE Real all(float v) { return _mm512_set1_ps(v); }
    static DLPOLY_INLINE Real real(Fixed v) { return _mm512_cvtepi32_ps(v); }
    static DLPOLY_INLINE Real difference(Fixed a, Fixed b) { return _mm512_cvtepi32_ps(_mm512_sub_epi32(a, b)); }
    static DLPOLY_INLINE Real multiply(Real a, Real b) { return _mm512_mul_ps(a, b); }
    static DLPOLY_INLINE Real add(Real a, Real b) { return _mm512_add_ps(a, b); }
    static DLPOLY_INLINE Real subtract(Real a, Real b) { return _mm512_sub_ps(a, b); }
    static DLPOLY_INLINE Real multiply_add(Real a, Real b, Real c) { return _mm512_fmadd_ps(a, b, c); }
    static DLPOLY_INLINE Real negative_multiply_add(Real a, Real b, Real c) { return _mm512_fnmadd_ps(a, b, c); }
    static DLPOLY_INLINE Real multiply_where(Mask m, Real a, Real b) { return _mm512_maskz_mul_ps(m, a, b); }
    static DLPOLY_INLINE Mask positive(Real w, int lanes) {
        const auto used = static_cast<Mask>(lanes >= width ? 0xFFFF : (1 << lanes) - 1);
        return _mm512_mask_cmp_ps_mask(used, w, _mm512_setzero_ps(), _CMP_GT_OQ);
    }

    // 14 bits from the processor, doubled by one Newton step. Coincident beads get a large finite number.
    static DLPOLY_INLINE Real inverse_root(Real x) {
        x = _mm512_max_ps(x, _mm512_set1_ps(1e-30F));
        const Real y = _mm512_rsqrt14_ps(x);
        const Real half = _mm512_mul_ps(y, _mm512_set1_ps(0.5F));
        return _mm512_mul_ps(half, _mm512_fnmadd_ps(_mm512_mul_ps(x, y), y, _mm512_set1_ps(3.0F)));
    }

    static DLPOLY_INLINE Real noise(__m512i a, __m512i b) {
        __m512i x = _mm512_add_epi32(a, b);
        x = _mm512_xor_si512(x, _mm512_srli_epi32(x, 16));
        x = _mm512_mullo_epi32(x, _mm512_set1_epi32(0x7feb352d));
        x = _mm512_xor_si512(x, _mm512_srli_epi32(x, 15));
        x = _mm512_mullo_epi32(x, _mm512_set1_epi32(static_cast<int>(0x846ca68bU)));
        return _mm512_cvtepi32_ps(x);
    }

    // Constants of pairs, one a lane; the tables behind them hold one entry a kind.
    struct Pairs {
        __m512 repulsion, drag, noise, inverse_cutoff, energy, inverse_mass;
    };
    using Tables = Pairs;
    static DLPOLY_INLINE Pairs only_pair(const PairRow<float>& row, float inverse_mass) {
        return {all(row.repulsion[0]),      all(row.drag[0]),   all(row.noise[0]),
                all(row.inverse_cutoff[0]), all(row.energy[0]), all(inverse_mass)};
    }
    static DLPOLY_INLINE Tables tables(const PairRow<float>& row, const float* inverse_mass) {
        return {_mm512_loadu_ps(row.repulsion),      _mm512_loadu_ps(row.drag),   _mm512_loadu_ps(row.noise),
                _mm512_loadu_ps(row.inverse_cutoff), _mm512_loadu_ps(row.energy), _mm512_loadu_ps(inverse_mass)};
    }
    template <bool drag, bool observe>
    static DLPOLY_INLINE Pairs look_up(const Tables& t, __m512i tag) {
        const __m512i kind = _mm512_srli_epi32(tag, kind_shift);
        Pairs result{};
        result.repulsion = _mm512_permutexvar_ps(kind, t.repulsion);
        result.inverse_cutoff = _mm512_permutexvar_ps(kind, t.inverse_cutoff);
        if constexpr (drag) {
            result.drag = _mm512_permutexvar_ps(kind, t.drag);
            result.noise = _mm512_permutexvar_ps(kind, t.noise);
            result.inverse_mass = _mm512_permutexvar_ps(kind, t.inverse_mass);
        }
        if constexpr (observe) {
            result.energy = _mm512_permutexvar_ps(kind, t.energy);
        }
        return result;
    }

    static DLPOLY_INLINE Sum no_sum() { return _mm512_setzero_si512(); }
    static DLPOLY_INLINE Sum add_nearest(Sum sum, Real v) { return _mm512_add_epi32(sum, _mm512_cvtps_epi32(v)); }

    static DLPOLY_INLINE void store_sums(Sum x, Sum y, Sum z, int32_t* out) {
        // Transposed while folded: every 128-bit part of the last vector holds x, y, z and nothing.
        const __m512i nothing = _mm512_setzero_si512();
        const __m512i xy = _mm512_add_epi32(_mm512_unpacklo_epi32(x, y), _mm512_unpackhi_epi32(x, y));
        const __m512i z_ = _mm512_add_epi32(_mm512_unpacklo_epi32(z, nothing), _mm512_unpackhi_epi32(z, nothing));
        const __m512i xyz = _mm512_add_epi32(_mm512_unpacklo_epi64(xy, z_), _mm512_unpackhi_epi64(xy, z_));
        const __m256i half = _mm256_add_epi32(_mm512_castsi512_si256(xyz), _mm512_extracti64x4_epi64(xyz, 1));
        _mm_store_si128(reinterpret_cast<__m128i*>(out),
                        _mm_add_epi32(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1)));
    }

    static DLPOLY_INLINE double total(Real v) {
        const __m512d wide =
            _mm512_add_pd(_mm512_cvtps_pd(_mm512_castps512_ps256(v)), _mm512_cvtps_pd(_mm512_extractf32x8_ps(v, 1)));
        return _mm512_reduce_add_pd(wide);
    }

  private:
    struct Quarter {
        __m512 first, second, third, fourth;
    };
    // 4×4 transposition in every 128-bit part.
    static DLPOLY_INLINE Quarter transpose(__m512 a, __m512 b, __m512 c, __m512 d) {
        const __m512 t0 = _mm512_unpacklo_ps(a, b), t1 = _mm512_unpackhi_ps(a, b);
        const __m512 t2 = _mm512_unpacklo_ps(c, d), t3 = _mm512_unpackhi_ps(c, d);
        return {_mm512_shuffle_ps(t0, t2, 0x44), _mm512_shuffle_ps(t0, t2, 0xEE), _mm512_shuffle_ps(t1, t3, 0x44),
                _mm512_shuffle_ps(t1, t3, 0xEE)};
    }
};

// The same as advance_bead and cell_of of pass.hpp, three axes at a time.
struct DoubleAdvance {
    struct Advance {
        explicit Advance(const PassArguments<DoubleRecord>& a)
            : counts(_mm256_setr_epi64x(a.cells_x, a.rows_y, a.rows_z, 0)),
              axes(_mm256_setr_epi64x(-1, -1, -1, 0)),
              out_of_range(_mm256_setzero_si256()),
              drifts(a.drift),
              images(a.images),
              ranks(a.row_rank),
              rows_y(a.rows_y),
              cells_x(a.cells_x) {}

        DLPOLY_INLINE int32_t operator()(const DoubleRecord& bead, const int64_t* impulse, DoubleRecord& out) {
            const __m256i* from = reinterpret_cast<const __m256i*>(&bead);
            const __m256d drift = _mm256_set1_pd(drifts[bead.tag >> kind_shift]);
            const __mmask8 mobile = _mm256_cmp_pd_mask(drift, _mm256_setzero_pd(), _CMP_NEQ_OQ) & 7;
            const __m256i momentum =
                _mm256_mask_add_epi64(_mm256_load_si256(from + 1), mobile, _mm256_load_si256(from + 1),
                                      _mm256_load_si256(reinterpret_cast<const __m256i*>(impulse)));
            // Positions have 48 bits, at the top; lane 3 holds word and tag and stays.
            const __m256i step = _mm256_and_si256(
                _mm256_slli_epi64(_mm256_cvtpd_epi64(_mm256_mul_pd(_mm256_cvtepi64_pd(momentum), drift)), 16), axes);
            const __m256i before = _mm256_load_si256(from);
            const __m256i after = _mm256_add_epi64(before, step);
            _mm256_store_si256(reinterpret_cast<__m256i*>(&out), after);
            _mm256_store_si256(reinterpret_cast<__m256i*>(&out) + 1, momentum);

            const __m256i crossed = _mm256_and_si256(_mm256_xor_si256(before, after), _mm256_xor_si256(step, after));
            const int crossings = _mm256_movemask_pd(_mm256_castsi256_pd(crossed)) & 7;
            if (__builtin_expect(crossings != 0, 0)) {
                count_crossings(images, bead.tag & id_mask, crossings, _mm256_movemask_pd(_mm256_castsi256_pd(before)));
            }
            // What is left of a momentum in range, made positive, has no upper bits.
            constexpr int bits = DoubleRecord::momentum_bits;
            out_of_range = _mm256_or_si256(
                out_of_range,
                _mm256_srli_epi64(_mm256_add_epi64(momentum, _mm256_set1_epi64x(int64_t{1} << bits)), bits + 1));

            // Upper 32 of the 96 bits of position times count, from two products.
            const __m256i low = _mm256_srli_epi64(_mm256_mul_epu32(after, counts), 32);
            const __m256i cells =
                _mm256_srli_epi64(_mm256_add_epi64(_mm256_mul_epu32(_mm256_srli_epi64(after, 32), counts), low), 32);
            const __m128i xy = _mm256_castsi256_si128(cells);
            const int32_t row =
                _mm_cvtsi128_si32(_mm256_extracti128_si256(cells, 1)) * rows_y + _mm_extract_epi32(xy, 2);
            return ranks[row] * cells_x + _mm_cvtsi128_si32(xy);
        }

        [[nodiscard]] uint64_t overflow() const { return _mm256_testz_si256(out_of_range, axes) != 0 ? 0 : 1; }

      private:
        __m256i counts, axes, out_of_range;
        const double* drifts;
        int32_t* images;
        const int32_t* ranks;
        int32_t rows_y, cells_x;
    };
};

struct DoubleLanes : CommonLanes<DoubleRecord>, DoubleAdvance {
    static constexpr int width = 8;
    using Real = __m512d;
    using Fixed = __m512i;
    using Sum = __m512i;
    using Mask = __mmask8;

    struct Beads {
        __m512i x, y, z, px, py, pz;
        __m256i word, tag;
    };

    static DLPOLY_INLINE Beads broadcast(const DoubleRecord& r) {
        const auto all_of = [](int64_t v) { return _mm512_set1_epi64(v); };
        return {all_of(r.x),
                all_of(r.y),
                all_of(r.z),
                all_of(r.px),
                all_of(r.py),
                all_of(r.pz),
                _mm256_set1_epi32(static_cast<int>(r.word)),
                _mm256_set1_epi32(static_cast<int>(r.tag))};
    }

    // Eight records of two halves: x y z (word, tag) and px py pz −, four 64-bit numbers each.
    static DLPOLY_INLINE Beads load(const DoubleRecord* records, const uint32_t* offsets, const uint8_t* accepted) {
        const char* base = reinterpret_cast<const char*>(records);
        const auto half = [&](int lane, int part) {
            return _mm256_load_pd(reinterpret_cast<const double*>(base + offsets[accepted[lane]] + 32 * part));
        };
        const auto two = [&](int lane, int part) {
            return _mm512_insertf64x4(_mm512_castpd256_pd512(half(lane, part)), half(lane + 4, part), 1);
        };
        const Quarter position = transpose(two(0, 0), two(1, 0), two(2, 0), two(3, 0));
        const Quarter momentum = transpose(two(0, 1), two(1, 1), two(2, 1), two(3, 1));
        const __m512i both = _mm512_castpd_si512(position.fourth);
        return {_mm512_castpd_si512(position.first),  _mm512_castpd_si512(position.second),
                _mm512_castpd_si512(position.third),  _mm512_castpd_si512(momentum.first),
                _mm512_castpd_si512(momentum.second), _mm512_castpd_si512(momentum.third),
                _mm512_cvtepi64_epi32(both),          _mm512_cvtepi64_epi32(_mm512_srli_epi64(both, 32))};
    }

    static DLPOLY_INLINE Real all(double v) { return _mm512_set1_pd(v); }
    static DLPOLY_INLINE Real real(Fixed v) { return _mm512_cvtepi64_pd(v); }
    static DLPOLY_INLINE Real difference(Fixed a, Fixed b) { return _mm512_cvtepi64_pd(_mm512_sub_epi64(a, b)); }
    static DLPOLY_INLINE Real multiply(Real a, Real b) { return _mm512_mul_pd(a, b); }
    static DLPOLY_INLINE Real add(Real a, Real b) { return _mm512_add_pd(a, b); }
    static DLPOLY_INLINE Real subtract(Real a, Real b) { return _mm512_sub_pd(a, b); }
    static DLPOLY_INLINE Real multiply_add(Real a, Real b, Real c) { return _mm512_fmadd_pd(a, b, c); }
    static DLPOLY_INLINE Real negative_multiply_add(Real a, Real b, Real c) { return _mm512_fnmadd_pd(a, b, c); }
    static DLPOLY_INLINE Real multiply_where(Mask m, Real a, Real b) { return _mm512_maskz_mul_pd(m, a, b); }
    static DLPOLY_INLINE Mask positive(Real w, int lanes) {
        const auto used = static_cast<Mask>(lanes >= width ? 0xFF : (1 << lanes) - 1);
        return _mm512_mask_cmp_pd_mask(used, w, _mm512_setzero_pd(), _CMP_GT_OQ);
    }

    // 14 bits from the processor, two Newton steps.
    static DLPOLY_INLINE Real inverse_root(Real x) {
        x = _mm512_max_pd(x, _mm512_set1_pd(1e-60));
        Real y = _mm512_rsqrt14_pd(x);
        for (int round = 0; round < 2; ++round) {
            const Real half = _mm512_mul_pd(y, _mm512_set1_pd(0.5));
            y = _mm512_mul_pd(half, _mm512_fnmadd_pd(_mm512_mul_pd(x, y), y, _mm512_set1_pd(3.0)));
        }
        return y;
    }

    static DLPOLY_INLINE Real noise(__m256i a, __m256i b) {
        __m256i x = _mm256_add_epi32(a, b);
        x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 16));
        x = _mm256_mullo_epi32(x, _mm256_set1_epi32(0x7feb352d));
        x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 15));
        x = _mm256_mullo_epi32(x, _mm256_set1_epi32(static_cast<int>(0x846ca68bU)));
        return _mm512_cvtepi32_pd(x);
    }

    struct Table {
        __m512d low, high;
    };
    struct Tables {
        Table repulsion, drag, noise, inverse_cutoff, energy, inverse_mass;
    };
    struct Pairs {
        __m512d repulsion, drag, noise, inverse_cutoff, energy, inverse_mass;
    };
    static DLPOLY_INLINE Pairs only_pair(const PairRow<double>& row, double inverse_mass) {
        return {all(row.repulsion[0]),      all(row.drag[0]),   all(row.noise[0]),
                all(row.inverse_cutoff[0]), all(row.energy[0]), all(inverse_mass)};
    }
    static DLPOLY_INLINE Tables tables(const PairRow<double>& row, const double* inverse_mass) {
        const auto table = [](const double* values) -> Table {
            return {_mm512_loadu_pd(values), _mm512_loadu_pd(values + 8)};
        };
        return {table(row.repulsion),      table(row.drag),   table(row.noise),
                table(row.inverse_cutoff), table(row.energy), table(inverse_mass)};
    }
    template <bool drag, bool observe>
    static DLPOLY_INLINE Pairs look_up(const Tables& t, __m256i tag) {
        const __m512i kind = _mm512_cvtepu32_epi64(_mm256_srli_epi32(tag, kind_shift));
        const auto pick = [kind](const Table& table) { return _mm512_permutex2var_pd(table.low, kind, table.high); };
        Pairs result{};
        result.repulsion = pick(t.repulsion);
        result.inverse_cutoff = pick(t.inverse_cutoff);
        if constexpr (drag) {
            result.drag = pick(t.drag);
            result.noise = pick(t.noise);
            result.inverse_mass = pick(t.inverse_mass);
        }
        if constexpr (observe) {
            result.energy = pick(t.energy);
        }
        return result;
    }

    static DLPOLY_INLINE Sum no_sum() { return _mm512_setzero_si512(); }
    static DLPOLY_INLINE Sum add_nearest(Sum sum, Real v) { return _mm512_add_epi64(sum, _mm512_cvtpd_epi64(v)); }

    static DLPOLY_INLINE void store_sums(Sum x, Sum y, Sum z, int64_t* out) {
        // Transposed while folded, as for single precision.
        const __m512i nothing = _mm512_setzero_si512();
        const auto fold = [](__m512i v) {
            return _mm256_add_epi64(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
        };
        const __m256i xy = fold(_mm512_add_epi64(_mm512_unpacklo_epi64(x, y), _mm512_unpackhi_epi64(x, y)));
        const __m256i z_ = fold(_mm512_add_epi64(_mm512_unpacklo_epi64(z, nothing), _mm512_unpackhi_epi64(z, nothing)));
        _mm256_store_si256(reinterpret_cast<__m256i*>(out), _mm256_add_epi64(_mm256_permute2x128_si256(xy, z_, 0x20),
                                                                             _mm256_permute2x128_si256(xy, z_, 0x31)));
    }

    static DLPOLY_INLINE double total(Real v) { return _mm512_reduce_add_pd(v); }

  private:
    struct Quarter {
        __m512d first, second, third, fourth;
    };
    // Rows (0,4) (1,5) (2,6) (3,7) of four numbers each, turned into four vectors of lanes 0 … 7.
    static DLPOLY_INLINE Quarter transpose(__m512d a, __m512d b, __m512d c, __m512d d) {
        const __m512d t0 = _mm512_unpacklo_pd(a, b), t1 = _mm512_unpackhi_pd(a, b);
        const __m512d t2 = _mm512_unpacklo_pd(c, d), t3 = _mm512_unpackhi_pd(c, d);
        const __m512i outer = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        const __m512i inner = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        return {_mm512_permutex2var_pd(t0, outer, t2), _mm512_permutex2var_pd(t1, outer, t3),
                _mm512_permutex2var_pd(t0, inner, t2), _mm512_permutex2var_pd(t1, inner, t3)};
    }
};

}  // namespace dlpoly::fast::DLPOLY_SIMD
