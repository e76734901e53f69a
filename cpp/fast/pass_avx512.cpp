// The passes compiled for AVX-512; chosen at run time only where the processor has it.
#include "fast/arguments.hpp"

#ifdef DLPOLY_HAS_AVX512

#define DLPOLY_SIMD avx512
#include "fast/lanes_avx512.hpp"
#include "fast/pass_vector.hpp"
#include "fast/variants.hpp"

namespace dlpoly::fast {

namespace avx512 {

template <class Record, bool one_kind, bool drag, bool observe, bool last>
void mixed_pass(PassArguments<Record>& a, int32_t first, int32_t end) {
    vector_pass<MixedLanes, Record, one_kind, drag, observe, last>(a, first, end);
}

template <class Record, bool one_kind, bool drag, bool observe, bool last>
void double_pass(PassArguments<Record>& a, int32_t first, int32_t end) {
    vector_pass<DoubleLanes, Record, one_kind, drag, observe, last>(a, first, end);
}

static Pass<MixedRecord> mixed(Variant variant) { return DLPOLY_CHOOSE_PASS(mixed_pass, MixedRecord, variant); }
static Pass<DoubleRecord> in_double(Variant variant) { return DLPOLY_CHOOSE_PASS(double_pass, DoubleRecord, variant); }

}  // namespace avx512

const Passes* avx512_passes() {
    static constexpr Passes passes{"avx512", &avx512::mixed, &avx512::in_double};
    const bool supported = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
                           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
                           __builtin_cpu_supports("avx512vbmi") != 0 && __builtin_cpu_supports("avx512vbmi2") != 0 &&
                           __builtin_cpu_supports("fma") != 0 && __builtin_cpu_supports("bmi") != 0 &&
                           __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("popcnt") != 0;
    return supported ? &passes : nullptr;
}

}  // namespace dlpoly::fast

#else

namespace dlpoly::fast {

const Passes* avx512_passes() { return nullptr; }

}  // namespace dlpoly::fast

#endif
