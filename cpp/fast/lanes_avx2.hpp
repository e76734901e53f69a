// Lanes of AVX2 with FMA and BMI2 (Haswell, Zen and later): 8 pairs in single, 4 in double precision.
#pragma once

#include <immintrin.h>
#include <string.h>

#include "fast/lanes_x86.hpp"
#include "fast/pass.hpp"

namespace dlpoly::fast::DLPOLY_SIMD {

// The numbers of the set bits of each byte, lowest first, one a byte and the rest 0.
struct BitNumbers {
    uint64_t of[256];
};
constexpr BitNumbers make_bit_numbers() {
    BitNumbers result{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        int place = 0;
        for (unsigned bit = 0; bit < 8; ++bit) {
            if ((byte >> bit & 1U) != 0) {
                result.of[byte] |= uint64_t{bit} << (8 * place++);
            }
        }
    }
    return result;
}
alignas(64) inline constexpr BitNumbers bit_numbers = make_bit_numbers();

// Parts that do not depend on the precision: the 8-bit search and the random words.
template <class Record>
struct CommonLanes {
    static constexpr int copy_width = 32;

    static __m256i load_bytes(const void* from) { return _mm256_loadu_si256(static_cast<const __m256i*>(from)); }
    static DLPOLY_INLINE void store_bytes(void* to, __m256i v) { _mm256_storeu_si256(static_cast<__m256i*>(to), v); }

    static DLPOLY_INLINE void copy_shadows(const PassArguments<Record>& a, int32_t from, uint8_t* x, uint8_t* y,
                                           uint8_t* z, uint32_t* offset) {
        store_bytes(x, load_bytes(a.shadow_x + from));
        store_bytes(y, load_bytes(a.shadow_y + from));
        store_bytes(z, load_bytes(a.shadow_z + from));
        constexpr int size = sizeof(Record);
        const __m256i ramp = _mm256_setr_epi32(0, size, 2 * size, 3 * size, 4 * size, 5 * size, 6 * size, 7 * size);
        __m256i offsets =
            _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(static_cast<uint32_t>(from) * size)), ramp);
        for (int k = 0; k < copy_width; k += 8) {
            store_bytes(offset + k, offsets);
            offsets = _mm256_add_epi32(offsets, _mm256_set1_epi32(8 * size));
        }
    }

    // Squares of shadow distances are computed, where the tables of PassArguments would need more look-ups than this
    // instruction set is good at. A pair may be in range where Σ weight · (distance − 1)² / 2¹⁶ is below `limit`.
    struct SearchTables {
        __m256i weight_x, weight_y, weight_z, limit;
        bool isotropic;  // all weights are one: they are left out
    };

    // What a table adds for each squared resolution, from below, so that no pair in range is lost. Entry k is
    // (k − 1)² times that, rounded down; the largest ones tell it best.
    static DLPOLY_INLINE double slope(const uint8_t* table) {
        int last = 127;
        while (last > 2 && table[last] == 255) {
            --last;
        }
        double largest = 0.0;
        for (int k = last > 8 ? last - 6 : 2; k <= last; ++k) {
            const double value = table[k] / static_cast<double>((k - 1) * (k - 1));
            largest = value > largest ? value : largest;
        }
        return largest;
    }

    static DLPOLY_INLINE SearchTables search_tables(const PassArguments<Record>& a) {
        const double x = slope(a.distance_x), y = slope(a.distance_y), z = slope(a.distance_z);
        double largest = x > y ? x : y;
        largest = largest > z ? largest : z;
        // The coarsest axis keeps its squares; with weights of all others below one, sums stay below 3 · 127².
        const auto weight = [largest](double of_axis) {
            return _mm256_set1_epi16(static_cast<short>(static_cast<int>(65535.0 * of_axis / largest)));
        };
        const bool isotropic = x == y && y == z;
        // Two more than the largest sum: one for the division above, one for "below".
        const double most = largest > 0.0 ? (a.threshold + 1) / largest : 0.0;
        const int limit = largest > 0.0 && most < 32765.0 ? static_cast<int>(most) + 2 : 32767;
        return {weight(x), weight(y), weight(z), _mm256_set1_epi16(static_cast<short>(limit)), isotropic};
    }

    // Which of 32 candidates may be in range.
    template <bool isotropic>
    static DLPOLY_INLINE uint32_t near(const SearchTables& t, const uint8_t* x, const uint8_t* y, const uint8_t* z,
                                       __m256i own_x, __m256i own_y, __m256i own_z) {
        const __m256i zero = _mm256_setzero_si256();
        // Shadows d apart belong to coordinates at least d − 1 resolutions apart.
        const auto apart = [](const uint8_t* other, __m256i own) {
            return _mm256_subs_epu8(_mm256_abs_epi8(_mm256_sub_epi8(load_bytes(other), own)), _mm256_set1_epi8(1));
        };
        const __m256i dx = apart(x, own_x), dy = apart(y, own_y), dz = apart(z, own_z);
        const auto inside = [&](__m256i xy, __m256i z_only) {
            return _mm256_cmpgt_epi16(t.limit, _mm256_adds_epi16(xy, z_only));
        };
        const auto squares = [](__m256i v) { return _mm256_maddubs_epi16(v, v); };  // and their sums by twos
        __m256i low, high;
        if constexpr (isotropic) {
            low = inside(squares(_mm256_unpacklo_epi8(dx, dy)), squares(_mm256_unpacklo_epi8(dz, zero)));
            high = inside(squares(_mm256_unpackhi_epi8(dx, dy)), squares(_mm256_unpackhi_epi8(dz, zero)));
        } else {
            const auto part = [&](__m256i v, __m256i weight) { return _mm256_mulhi_epu16(squares(v), weight); };
            const auto low_part = [&](__m256i d, __m256i weight) {
                return part(_mm256_unpacklo_epi8(d, zero), weight);
            };
            const auto high_part = [&](__m256i d, __m256i weight) {
                return part(_mm256_unpackhi_epi8(d, zero), weight);
            };
            low =
                inside(_mm256_add_epi16(low_part(dx, t.weight_x), low_part(dy, t.weight_y)), low_part(dz, t.weight_z));
            high = inside(_mm256_add_epi16(high_part(dx, t.weight_x), high_part(dy, t.weight_y)),
                          high_part(dz, t.weight_z));
        }
        // Packing undoes the order of unpacking.
        return static_cast<uint32_t>(_mm256_movemask_epi8(_mm256_packs_epi16(low, high)));
    }

    // Writes the numbers of the candidates that may be in range of bead i, which is number `self` itself.
    // Returns how many, or −1 when they are more than the list holds.
    static DLPOLY_INLINE int accept(const SearchTables& t, const PassArguments<Record>& a, int32_t i, const uint8_t* x,
                                    const uint8_t* y, const uint8_t* z, int count, int self, uint8_t* accepted) {
        return t.isotropic ? accept_from<true>(t, a, i, x, y, z, count, self, accepted)
                           : accept_from<false>(t, a, i, x, y, z, count, self, accepted);
    }

    template <bool isotropic>
    static DLPOLY_INLINE int accept_from(const SearchTables& t, const PassArguments<Record>& a, int32_t i,
                                         const uint8_t* x, const uint8_t* y, const uint8_t* z, int count, int self,
                                         uint8_t* accepted) {
        const __m256i own_x = _mm256_set1_epi8(static_cast<char>(a.shadow_x[i]));
        const __m256i own_y = _mm256_set1_epi8(static_cast<char>(a.shadow_y[i]));
        const __m256i own_z = _mm256_set1_epi8(static_cast<char>(a.shadow_z[i]));
        constexpr uint64_t each_byte = 0x0101010101010101U;
        uint8_t* next = accepted;
        for (int k = 0; k < count; k += 64) {
            const int left = count - k < 64 ? count - k : 64;
            uint64_t mask = near<isotropic>(t, x + k, y + k, z + k, own_x, own_y, own_z);
            if (left > 32) {
                mask |= uint64_t{near<isotropic>(t, x + k + 32, y + k + 32, z + k + 32, own_x, own_y, own_z)} << 32;
            }
            mask = _bzhi_u64(mask, static_cast<unsigned>(left));
            if (self >= k && self < k + 64) {
                mask &= ~(uint64_t{1} << (self - k));
            }
            // Eight candidates at a time; each store is overwritten from the first number that it does not hold.
            uint64_t numbers = each_byte * static_cast<unsigned>(k);
            for (int g = 0; g < left; g += 8) {
                const auto byte = static_cast<unsigned>(mask & 0xFFU);
                const uint64_t found = bit_numbers.of[byte] + numbers;
                memcpy(next, &found, 8);
                next += __builtin_popcount(byte);
                numbers += 8 * each_byte;
                mask >>= 8;
            }
            if (next - accepted > most_accepted) {
                return -1;
            }
        }
        memset(next, 0, 8);  // a whole vector of records is loaded at the end of the list
        return static_cast<int>(next - accepted);
    }

    // The constants of pairs that a pass needs, each looked up in its table.
    template <bool drag, bool observe, class Pairs, class Tables, class LookUp>
    static DLPOLY_INLINE Pairs pick(const Tables& t, LookUp look_up) {
        Pairs result{};
        result.repulsion = look_up(t.row.repulsion);
        result.inverse_cutoff = look_up(t.row.inverse_cutoff);
        if constexpr (drag) {
            result.drag = look_up(t.row.drag);
            result.noise = look_up(t.row.noise);
            result.inverse_mass = look_up(t.inverse_mass);
        }
        if constexpr (observe) {
            result.energy = look_up(t.row.energy);
        }
        return result;
    }

    // Philox2x32-10 of four ids at a time; see core/bead_words.hpp.
    static DLPOLY_INLINE void bead_words(const uint32_t* ids, uint32_t* words, int32_t count, const uint32_t* key) {
        const __m256i multiplier = _mm256_set1_epi64x(0xD256D193);
        const __m256i high_mask = _mm256_set1_epi64x(static_cast<int64_t>(0xFFFFFFFF00000000ULL));
        const __m256i first_halves = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
        for (int32_t k = 0; k < count; k += 4) {
            const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(ids + k));
            __m256i low = _mm256_cvtepu32_epi64(_mm_xor_si128(four, _mm_set1_epi32(static_cast<int>(key[1]))));
            __m256i high = _mm256_set1_epi64x(static_cast<int64_t>(key[2]));
            uint32_t round_key = key[0];
            for (int round = 0; round < 10; ++round) {
                const __m256i product = _mm256_mul_epu32(multiplier, low);
                low = _mm256_xor_si256(_mm256_srli_epi64(product, 32),
                                       _mm256_xor_si256(_mm256_set1_epi64x(static_cast<int64_t>(round_key)), high));
                high = _mm256_andnot_si256(high_mask, product);
                round_key += 0x9E3779B9U;
            }
            _mm_storeu_si128(reinterpret_cast<__m128i*>(words + k),
                             _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(low, first_halves)));
        }
    }
};

struct MixedLanes : CommonLanes<MixedRecord>, MixedAdvance {
    static constexpr int width = 8;
    using Real = __m256;
    using Fixed = __m256i;
    using Sum = __m256i;
    using Mask = __m256;

    struct Beads {
        __m256i x, y, z, word, px, py, pz, tag;
    };

    static DLPOLY_INLINE Beads broadcast(const MixedRecord& r) {
        const auto all_of = [](auto v) { return _mm256_set1_epi32(static_cast<int>(v)); };
        return {all_of(r.x),  all_of(r.y),  all_of(r.z),  all_of(r.word),
                all_of(r.px), all_of(r.py), all_of(r.pz), all_of(r.tag)};
    }

    // Eight records of eight 32-bit numbers, turned into eight vectors. Plain loads and shuffles: hardware gathers are
    // slower.
    static DLPOLY_INLINE Beads load(const MixedRecord* records, const uint32_t* offsets, const uint8_t* accepted) {
        const char* base = reinterpret_cast<const char*>(records);
        const char* at[width];
        for (int lane = 0; lane < width; ++lane) {
            at[lane] = base + offsets[accepted[lane]];
        }
        // Rows hold records (lane, lane + 4), either the position or the momentum half.
        const auto two = [&](int lane, int part) {
            const __m128 first = _mm_load_ps(reinterpret_cast<const float*>(at[lane] + 16 * part));
            const __m128 second = _mm_load_ps(reinterpret_cast<const float*>(at[lane + 4] + 16 * part));
            return _mm256_insertf128_ps(_mm256_castps128_ps256(first), second, 1);
        };
        Beads result;
        transpose(two(0, 0), two(1, 0), two(2, 0), two(3, 0), &result.x, &result.y, &result.z, &result.word);
        transpose(two(0, 1), two(1, 1), two(2, 1), two(3, 1), &result.px, &result.py, &result.pz, &result.tag);
        return result;
    }

    static DLPOLY_INLINE Real all(float v) { return _mm256_set1_ps(v); }
    static DLPOLY_INLINE Real real(Fixed v) { return _mm256_cvtepi32_ps(v); }
    static DLPOLY_INLINE Real difference(Fixed a, Fixed b) { return _mm256_cvtepi32_ps(_mm256_sub_epi32(a, b)); }
    static DLPOLY_INLINE Real multiply(Real a, Real b) { return _mm256_mul_ps(a, b); }
    static DLPOLY_INLINE Real add(Real a, Real b) { return _mm256_add_ps(a, b); }
    static DLPOLY_INLINE Real subtract(Real a, Real b) { return _mm256_sub_ps(a, b); }
    static DLPOLY_INLINE Real multiply_add(Real a, Real b, Real c) { return _mm256_fmadd_ps(a, b, c); }
    static DLPOLY_INLINE Real negative_multiply_add(Real a, Real b, Real c) { return _mm256_fnmadd_ps(a, b, c); }
    static DLPOLY_INLINE Real multiply_where(Mask m, Real a, Real b) { return _mm256_and_ps(m, _mm256_mul_ps(a, b)); }
    static DLPOLY_INLINE Mask positive(Real w, int lanes) {
        const __m256i used = _mm256_cmpgt_epi32(_mm256_set1_epi32(lanes), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
        return _mm256_and_ps(_mm256_castsi256_ps(used), _mm256_cmp_ps(w, _mm256_setzero_ps(), _CMP_GT_OQ));
    }

    // 11 bits from the processor, tripled: y (1 + e/2 + 3e²/8) with e = 1 − x y². Coincident beads get a large finite
    // number.
    static DLPOLY_INLINE Real inverse_root(Real x) {
        x = _mm256_max_ps(x, all(1e-30F));
        const Real y = _mm256_rsqrt_ps(x);
        const Real e = _mm256_fnmadd_ps(_mm256_mul_ps(x, y), y, all(1.0F));
        return _mm256_fmadd_ps(_mm256_mul_ps(y, e), _mm256_fmadd_ps(e, all(0.375F), all(0.5F)), y);
    }

    static DLPOLY_INLINE Real noise(__m256i a, __m256i b) {
        __m256i x = _mm256_add_epi32(a, b);
        x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 16));
        x = _mm256_mullo_epi32(x, _mm256_set1_epi32(0x7feb352d));
        x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 15));
        x = _mm256_mullo_epi32(x, _mm256_set1_epi32(static_cast<int>(0x846ca68bU)));
        return _mm256_cvtepi32_ps(x);
    }

    // Constants of pairs, one a lane.
    struct Pairs {
        __m256 repulsion, drag, noise, inverse_cutoff, energy, inverse_mass;
    };
    static DLPOLY_INLINE Pairs only_pair(const PairRow<float>& row, float inverse_mass) {
        return {all(row.repulsion[0]),      all(row.drag[0]),   all(row.noise[0]),
                all(row.inverse_cutoff[0]), all(row.energy[0]), all(inverse_mass)};
    }

    // Tables are read where they are: there are too few registers for them.
    struct Tables {
        const PairRow<float>& row;
        const float* inverse_mass;
        bool more;  // than the eight kinds that one look-up reaches; kinds that exist have a cutoff
    };
    static DLPOLY_INLINE Tables tables(const PairRow<float>& row, const float* inverse_mass) {
        return {row, inverse_mass, row.inverse_cutoff[8] > 0.0F};
    }
    template <bool drag, bool observe>
    static DLPOLY_INLINE Pairs look_up(const Tables& t, __m256i tag) {
        const __m256i kind = _mm256_srli_epi32(tag, kind_shift);
        const auto low = [&](const float* table) { return _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), kind); };
        if (__builtin_expect(t.more, 0)) {
            // The uppermost bit of the kind is that of the tag.
            return pick<drag, observe, Pairs>(t, [&](const float* table) {
                return _mm256_blendv_ps(low(table), low(table + 8), _mm256_castsi256_ps(tag));
            });
        }
        return pick<drag, observe, Pairs>(t, low);
    }

    static DLPOLY_INLINE Sum no_sum() { return _mm256_setzero_si256(); }
    static DLPOLY_INLINE Sum add_nearest(Sum sum, Real v) { return _mm256_add_epi32(sum, _mm256_cvtps_epi32(v)); }

    static DLPOLY_INLINE void store_sums(Sum x, Sum y, Sum z, int32_t* out) {
        const auto fold = [](__m256i v) {
            return _mm_add_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
        };
        const __m128i fx = fold(x), fy = fold(y), fz = fold(z);
        const __m128i xy = _mm_add_epi32(_mm_unpacklo_epi32(fx, fy), _mm_unpackhi_epi32(fx, fy));
        const __m128i zz = _mm_add_epi32(_mm_unpacklo_epi32(fz, fz), _mm_unpackhi_epi32(fz, fz));
        _mm_store_si128(reinterpret_cast<__m128i*>(out),
                        _mm_add_epi32(_mm_unpacklo_epi64(xy, zz), _mm_unpackhi_epi64(xy, zz)));
    }

    static DLPOLY_INLINE double total(Real v) {
        const __m256d four =
            _mm256_add_pd(_mm256_cvtps_pd(_mm256_castps256_ps128(v)), _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1)));
        const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
        return _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
    }

  private:
    // 4×4 transposition in both 128-bit halves.
    static DLPOLY_INLINE void transpose(__m256 a, __m256 b, __m256 c, __m256 d, __m256i* first, __m256i* second,
                                        __m256i* third, __m256i* fourth) {
        const __m256 t0 = _mm256_unpacklo_ps(a, b), t1 = _mm256_unpackhi_ps(a, b);
        const __m256 t2 = _mm256_unpacklo_ps(c, d), t3 = _mm256_unpackhi_ps(c, d);
        *first = _mm256_castps_si256(_mm256_shuffle_ps(t0, t2, 0x44));
        *second = _mm256_castps_si256(_mm256_shuffle_ps(t0, t2, 0xEE));
        *third = _mm256_castps_si256(_mm256_shuffle_ps(t1, t3, 0x44));
        *fourth = _mm256_castps_si256(_mm256_shuffle_ps(t1, t3, 0xEE));
    }
};

// There is no conversion between 64-bit integers and doubles. Adding a number whose last bit stands for one makes an
// integer appear in the bits of the sum, and the reverse. Exact below 2⁵¹.
inline constexpr double ones = 0x1.8p52;

DLPOLY_INLINE __m256d to_double(__m256i v) {
    const __m256d shift = _mm256_set1_pd(ones);
    return _mm256_sub_pd(_mm256_castsi256_pd(_mm256_add_epi64(v, _mm256_castpd_si256(shift))), shift);
}
// The nearest integer; what is larger than 2⁵¹ becomes at least that, which is out of range for a momentum.
DLPOLY_INLINE __m256i to_nearest(__m256d v) {
    const __m256d shift = _mm256_set1_pd(ones);
    return _mm256_sub_epi64(_mm256_castpd_si256(_mm256_add_pd(v, shift)), _mm256_castpd_si256(shift));
}

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
            const __m256i mobile = _mm256_castpd_si256(_mm256_cmp_pd(drift, _mm256_setzero_pd(), _CMP_NEQ_OQ));
            const __m256i kick = _mm256_and_si256(
                _mm256_and_si256(_mm256_load_si256(reinterpret_cast<const __m256i*>(impulse)), axes), mobile);
            const __m256i momentum = _mm256_add_epi64(_mm256_load_si256(from + 1), kick);
            // Positions have 48 bits, at the top; lane 3 holds word and tag and stays.
            const __m256i step =
                _mm256_and_si256(_mm256_slli_epi64(to_nearest(_mm256_mul_pd(to_double(momentum), drift)), 16), axes);
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
    static constexpr int width = 4;
    using Real = __m256d;
    using Sum = __m256i;
    using Mask = __m256d;

    // Positions and momenta are converted in different ways.
    struct Place {
        __m256i v;
    };
    struct Momentum {
        __m256i v;
    };
    struct Beads {
        Place x, y, z;
        Momentum px, py, pz;
        __m128i word;
        __m128i tag;
    };

    static DLPOLY_INLINE Beads broadcast(const DoubleRecord& r) {
        const auto all_of = [](int64_t v) { return _mm256_set1_epi64x(v); };
        return {{all_of(r.x)},
                {all_of(r.y)},
                {all_of(r.z)},
                {all_of(r.px)},
                {all_of(r.py)},
                {all_of(r.pz)},
                _mm_set1_epi32(static_cast<int>(r.word)),
                _mm_set1_epi32(static_cast<int>(r.tag))};
    }

    // Four records of two halves: x y z (word, tag) and px py pz −, four 64-bit numbers each.
    static DLPOLY_INLINE Beads load(const DoubleRecord* records, const uint32_t* offsets, const uint8_t* accepted) {
        const char* base = reinterpret_cast<const char*>(records);
        const char* at[width];
        for (int lane = 0; lane < width; ++lane) {
            at[lane] = base + offsets[accepted[lane]];
        }
        // Quarter q of records (lane, lane + 2).
        const auto two = [&](int lane, int q) {
            const __m128d first = _mm_load_pd(reinterpret_cast<const double*>(at[lane] + 16 * q));
            const __m128d second = _mm_load_pd(reinterpret_cast<const double*>(at[lane + 2] + 16 * q));
            return _mm256_insertf128_pd(_mm256_castpd128_pd256(first), second, 1);
        };
        const auto low = [](__m256d a, __m256d b) { return _mm256_castpd_si256(_mm256_unpacklo_pd(a, b)); };
        const auto high = [](__m256d a, __m256d b) { return _mm256_castpd_si256(_mm256_unpackhi_pd(a, b)); };
        const __m256d xy0 = two(0, 0), xy1 = two(1, 0), zt0 = two(0, 1), zt1 = two(1, 1);
        const __m256d pxy0 = two(0, 2), pxy1 = two(1, 2), pz0 = two(0, 3), pz1 = two(1, 3);
        const __m256i both = high(zt0, zt1);
        const __m128 lower = _mm_castsi128_ps(_mm256_castsi256_si128(both));
        const __m128 upper = _mm_castsi128_ps(_mm256_extracti128_si256(both, 1));
        return {{low(xy0, xy1)},
                {high(xy0, xy1)},
                {low(zt0, zt1)},
                {low(pxy0, pxy1)},
                {high(pxy0, pxy1)},
                {low(pz0, pz1)},
                _mm_castps_si128(_mm_shuffle_ps(lower, upper, 0x88)),
                _mm_castps_si128(_mm_shuffle_ps(lower, upper, 0xDD))};
    }

    static DLPOLY_INLINE Real all(double v) { return _mm256_set1_pd(v); }

    // The 48 upper bits become the mantissa of 2⁶⁸ + u · 2¹⁶, u being offset by 2⁴⁷ to be positive. Exact.
    static DLPOLY_INLINE Real difference(Place a, Place b) {
        const __m256i offset = _mm256_set1_epi64x(INT64_MIN);
        const __m256i apart = _mm256_srli_epi64(_mm256_sub_epi64(_mm256_xor_si256(a.v, offset), b.v), 16);
        const __m256d number = _mm256_castsi256_pd(_mm256_or_si256(apart, _mm256_castpd_si256(all(0x1p68))));
        return _mm256_sub_pd(number, all(0x1p68 + 0x1p63));
    }
    // Momenta in range, and their differences, are below 2⁵¹.
    static DLPOLY_INLINE Real real(Momentum a) { return to_double(a.v); }
    static DLPOLY_INLINE Real difference(Momentum a, Momentum b) { return to_double(_mm256_sub_epi64(a.v, b.v)); }

    static DLPOLY_INLINE Real multiply(Real a, Real b) { return _mm256_mul_pd(a, b); }
    static DLPOLY_INLINE Real add(Real a, Real b) { return _mm256_add_pd(a, b); }
    static DLPOLY_INLINE Real subtract(Real a, Real b) { return _mm256_sub_pd(a, b); }
    static DLPOLY_INLINE Real multiply_add(Real a, Real b, Real c) { return _mm256_fmadd_pd(a, b, c); }
    static DLPOLY_INLINE Real negative_multiply_add(Real a, Real b, Real c) { return _mm256_fnmadd_pd(a, b, c); }
    static DLPOLY_INLINE Real multiply_where(Mask m, Real a, Real b) { return _mm256_and_pd(m, _mm256_mul_pd(a, b)); }
    static DLPOLY_INLINE Mask positive(Real w, int lanes) {
        const __m256i used = _mm256_cmpgt_epi64(_mm256_set1_epi64x(lanes), _mm256_setr_epi64x(0, 1, 2, 3));
        return _mm256_and_pd(_mm256_castsi256_pd(used), _mm256_cmp_pd(w, _mm256_setzero_pd(), _CMP_GT_OQ));
    }

    static DLPOLY_INLINE Real inverse_root(Real x) {
        x = _mm256_max_pd(x, all(1e-60));
        return _mm256_div_pd(all(1.0), _mm256_sqrt_pd(x));
    }

    static DLPOLY_INLINE Real noise(__m128i a, __m128i b) {
        __m128i x = _mm_add_epi32(a, b);
        x = _mm_xor_si128(x, _mm_srli_epi32(x, 16));
        x = _mm_mullo_epi32(x, _mm_set1_epi32(0x7feb352d));
        x = _mm_xor_si128(x, _mm_srli_epi32(x, 15));
        x = _mm_mullo_epi32(x, _mm_set1_epi32(static_cast<int>(0x846ca68bU)));
        return _mm256_cvtepi32_pd(x);
    }

    // Constants of pairs, one a lane.
    struct Pairs {
        __m256d repulsion, drag, noise, inverse_cutoff, energy, inverse_mass;
    };
    static DLPOLY_INLINE Pairs only_pair(const PairRow<double>& row, double inverse_mass) {
        return {all(row.repulsion[0]),      all(row.drag[0]),   all(row.noise[0]),
                all(row.inverse_cutoff[0]), all(row.energy[0]), all(inverse_mass)};
    }

    struct Tables {
        const PairRow<double>& row;
        const double* inverse_mass;
        bool more;  // than the four kinds that one look-up reaches; kinds that exist have a cutoff
    };
    static DLPOLY_INLINE Tables tables(const PairRow<double>& row, const double* inverse_mass) {
        return {row, inverse_mass, row.inverse_cutoff[4] > 0.0};
    }
    template <bool drag, bool observe>
    static DLPOLY_INLINE Pairs look_up(const Tables& t, __m128i tag) {
        const __m128i kind = _mm_srli_epi32(tag, kind_shift);
        if (__builtin_expect(t.more, 0)) {
            const __m256d every = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));
            return pick<drag, observe, Pairs>(t, [&](const double* table) {
                return _mm256_mask_i32gather_pd(_mm256_setzero_pd(), table, kind, every, 8);
            });
        }
        // A double is picked as its two halves, numbers 2 kind and 2 kind + 1.
        const __m256i twice = _mm256_cvtepu32_epi64(_mm_add_epi32(kind, kind));
        const __m256i halves =
            _mm256_or_si256(_mm256_or_si256(twice, _mm256_slli_epi64(twice, 32)), _mm256_set1_epi64x(int64_t{1} << 32));
        return pick<drag, observe, Pairs>(t, [&](const double* table) {
            const __m256 four = _mm256_castpd_ps(_mm256_loadu_pd(table));
            return _mm256_castps_pd(_mm256_permutevar8x32_ps(four, halves));
        });
    }

    static DLPOLY_INLINE Sum no_sum() { return _mm256_setzero_si256(); }
    static DLPOLY_INLINE Sum add_nearest(Sum sum, Real v) { return _mm256_add_epi64(sum, to_nearest(v)); }

    static DLPOLY_INLINE void store_sums(Sum x, Sum y, Sum z, int64_t* out) {
        const auto fold = [](__m256i v) {
            return _mm_add_epi64(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
        };
        const __m128i fx = fold(x), fy = fold(y), fz = fold(z);
        _mm_store_si128(reinterpret_cast<__m128i*>(out),
                        _mm_add_epi64(_mm_unpacklo_epi64(fx, fy), _mm_unpackhi_epi64(fx, fy)));
        out[2] = _mm_cvtsi128_si64(fz) + _mm_extract_epi64(fz, 1);
    }

    static DLPOLY_INLINE double total(Real v) {
        const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
        return _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
    }
};

}  // namespace dlpoly::fast::DLPOLY_SIMD
