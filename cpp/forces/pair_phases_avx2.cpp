// The phases compiled for AVX2; chosen at run time only where the processor has it.
#include "forces/pair_phases.hpp"

#ifdef DLPOLY_HAS_AVX2

#define DLPOLY_SIMD avx2
#include "forces/pair_phases_loops.hpp"

namespace dlpoly {

const Phases* avx2_phases() {
    static constexpr Phases phases{"avx2",       &avx2::search, &avx2::filter, &avx2::motion,
                                   &avx2::round, &avx2::add,    &avx2::observe};
    return __builtin_cpu_supports("avx2") != 0 ? &phases : nullptr;
}

}  // namespace dlpoly

#else

namespace dlpoly {

const Phases* avx2_phases() { return nullptr; }

}  // namespace dlpoly

#endif
