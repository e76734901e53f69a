// Weights over batches (see weight_loops.hpp).
#include "forces/weight_loops.hpp"

#include <cmath>

#include "core/power.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_phases.hpp"

#if defined(__GNUC__)
#define DLPOLY_RESTRICT __restrict
#else
#define DLPOLY_RESTRICT
#endif

namespace dlpoly {

namespace {

#define DLPOLY_WEIGHT_LOOPS(set, target)                                                            \
    target void set##_common(const double* DLPOLY_RESTRICT squared, double cutoff, double exponent, \
                             double* DLPOLY_RESTRICT power, std::size_t count) {                    \
        const std::size_t whole = count / batch_lanes * batch_lanes;                                \
        for (std::size_t k = 0; k < whole; ++k) {                                                   \
            power[k] = power_of(1.0 - std::sqrt(squared[k]) / cutoff, exponent);                    \
        }                                                                                           \
    }                                                                                               \
    target void set##_each(const double* DLPOLY_RESTRICT squared, double cutoff,                    \
                           const double* DLPOLY_RESTRICT exponent, double* DLPOLY_RESTRICT raised,  \
                           double* DLPOLY_RESTRICT logarithm, std::size_t count) {                  \
        const std::size_t whole = count / batch_lanes * batch_lanes;                                \
        for (std::size_t k = 0; k < whole; ++k) {                                                   \
            const double closeness = 1.0 - std::sqrt(squared[k]) / cutoff;                          \
            const bool some = closeness > 0.0;                                                      \
            logarithm[k] = power::logarithm(some ? closeness : 1.0);                                \
            const double value = power::exponential(exponent[k] * logarithm[k]);                    \
            raised[k] = some ? value : 0.0;                                                         \
        }                                                                                           \
    }                                                                                               \
    constexpr WeightLoops set##_loops{&set##_common, &set##_each};

DLPOLY_WEIGHT_LOOPS(plain, )
#ifdef DLPOLY_LAW_VECTORS
DLPOLY_WEIGHT_LOOPS(avx2, __attribute__((target("avx2"), flatten)))
DLPOLY_WEIGHT_LOOPS(avx512, __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw"), flatten)))
#endif

}  // namespace

const WeightLoops& weight_loops() {
#ifdef DLPOLY_LAW_VECTORS
    const Phases* chosen = &chosen_phases();
    if (chosen == avx512_phases()) {
        return avx512_loops;
    }
    if (chosen == avx2_phases()) {
        return avx2_loops;
    }
#endif
    return plain_loops;
}

}  // namespace dlpoly
