// Weights over batches (see weight_loops.hpp).
#include "forces/weight_loops.hpp"

#include <cmath>

#include "core/compiler.hpp"
#include "core/power.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_phases.hpp"

namespace dlpoly {

namespace {

struct Pairs {
    const double* distance_squared;
    double cutoff;
    std::size_t count;
};

// Always part of their callers, so that they are compiled for the callers' instruction set.
DLPOLY_ALWAYS_INLINE void run_common(const Pairs& pairs, double exponent, double* DLPOLY_RESTRICT raised) {
    const double* DLPOLY_RESTRICT squared = pairs.distance_squared;
    const double cutoff = pairs.cutoff;
    const std::size_t whole = pairs.count / batch_lanes * batch_lanes;
    for (std::size_t k = 0; k < whole; ++k) {
        raised[k] = power_of(1.0 - std::sqrt(squared[k]) / cutoff, exponent);
    }
}

#define DLPOLY_LOOPS_FOR(set, target)                                                              \
    target void set##_common(const double* squared, double cutoff, double exponent, double* power, \
                             std::size_t count) {                                                  \
        run_common({squared, cutoff, count}, exponent, power);                                     \
    }                                                                                              \
    constexpr WeightLoops set##_loops{&set##_common};

DLPOLY_LOOPS_FOR_EVERY_SET(DLPOLY_LOOPS_FOR)

}  // namespace

const WeightLoops& weight_loops() { return DLPOLY_CHOSEN_LOOPS; }

}  // namespace dlpoly
