// The loops of many-body DPD (see many_body_loops.hpp).
#include "meso/many_body_loops.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/compiler.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_phases.hpp"
#include "pair/arithmetic.hpp"

namespace dlpoly {

namespace {

// Added to a number below 2^51 it leaves the number, rounded half to even, in the low bits.
constexpr double rounding_offset = 0x1.8p52;

DLPOLY_ALWAYS_INLINE std::int64_t to_grid(double value) {
    return std::bit_cast<std::int64_t>(value + rounding_offset) - std::bit_cast<std::int64_t>(rounding_offset);
}

DLPOLY_ALWAYS_INLINE double closeness(double squared, double inverse_range) {
    return std::max(0.0, 1.0 - std::sqrt(squared) * inverse_range);
}

// Always part of their callers, so that they are compiled for the callers' instruction sets.
template <class Weight>
DLPOLY_ALWAYS_INLINE void run_density(const DensityLoop& loop, const Weight& weight) {
    const double* DLPOLY_RESTRICT squared = loop.squared;
    std::int64_t* DLPOLY_RESTRICT weights = loop.weights;
    const std::size_t count = loop.count / batch_lanes * batch_lanes;
    const double inverse_range = loop.inverse_range;
    const double height = loop.height;
    for (std::size_t k = 0; k < count; ++k) {
        weights[k] = to_grid(height * weight(closeness(squared[k], inverse_range)));
    }
}

template <class Weight>
DLPOLY_ALWAYS_INLINE void run_repulsion(const RepulsionLoop& loop, const Weight& weight) {
    const double* DLPOLY_RESTRICT squared = loop.squared;
    const std::uint32_t* DLPOLY_RESTRICT first = loop.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.second;
    const double* DLPOLY_RESTRICT response = loop.response;
    double* DLPOLY_RESTRICT conservative = loop.conservative;
    const std::size_t count = loop.count / batch_lanes * batch_lanes;
    const double inverse_range = loop.inverse_range;
    const double push = loop.push;
    // Apart from the arithmetic, which then needs no loads from anywhere but the batch.
    alignas(64) double both[batch_capacity + batch_lanes];
    for (std::size_t k = 0; k < count; ++k) {
        both[k] = response[first[k]] + response[second[k]];
    }
    for (std::size_t k = 0; k < count; ++k) {
        const double distance = std::sqrt(squared[k]);
        const double near = std::max(0.0, 1.0 - distance * inverse_range);
        conservative[k] += push * both[k] * weight(near) * pair::inverse_or_zero(distance);
    }
}

DLPOLY_ALWAYS_INLINE void quadratic_density(const DensityLoop& loop) {
    run_density(loop, [](double near) { return near * near; });
}

DLPOLY_ALWAYS_INLINE void power_density(const DensityLoop& loop) {
    const pair::Power power(loop.exponent);
    run_density(loop, [&power](double near) { return power(near); });
}

// Lucy, Astron. J. 82, 1013 (1977): (1 + 3s)(1 − s)³.
DLPOLY_ALWAYS_INLINE void lucy_density(const DensityLoop& loop) {
    run_density(loop, [](double near) { return (4.0 - 3.0 * near) * (near * near * near); });
}

DLPOLY_ALWAYS_INLINE void linear_repulsion(const RepulsionLoop& loop) {
    run_repulsion(loop, [](double near) { return near; });
}

DLPOLY_ALWAYS_INLINE void power_repulsion(const RepulsionLoop& loop) {
    const pair::Power power(loop.exponent - 1.0);
    run_repulsion(loop, [&power](double near) { return power(near); });
}

#define DLPOLY_LOOPS_FOR(set, attribute)                                                 \
    attribute void set##_quadratic(const DensityLoop& loop) { quadratic_density(loop); } \
    attribute void set##_power(const DensityLoop& loop) { power_density(loop); }         \
    attribute void set##_lucy(const DensityLoop& loop) { lucy_density(loop); }           \
    attribute void set##_linear(const RepulsionLoop& loop) { linear_repulsion(loop); }   \
    attribute void set##_steep(const RepulsionLoop& loop) { power_repulsion(loop); }     \
    constexpr ManyBodyLoops set##_loops{&set##_quadratic, &set##_power, &set##_lucy, &set##_linear, &set##_steep};

DLPOLY_LOOPS_FOR_EVERY_SET(DLPOLY_LOOPS_FOR)

}  // namespace

const ManyBodyLoops& many_body_loops() { return DLPOLY_CHOSEN_LOOPS; }

}  // namespace dlpoly
