// The loops of the exchange of heat (see heat_exchange_loops.hpp).
#include "meso/heat_exchange_loops.hpp"

#include <algorithm>
#include <cmath>

#include "core/bead_words.hpp"
#include "core/compiler.hpp"
#include "core/normal.hpp"
#include "core/power.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_phases.hpp"

namespace dlpoly {

namespace {

constexpr double gentle = 1.0 / 16;  // limit of the series below

struct Lanes {
    alignas(64) double values[heat_round_capacity];

    DLPOLY_ALWAYS_INLINE double& operator[](std::size_t k) { return values[k]; }
};

DLPOLY_ALWAYS_INLINE std::size_t whole_lanes(std::size_t count) {
    return (count + batch_lanes - 1) / batch_lanes * batch_lanes;
}

// 1 − e^{−x} for small x, exact to the last bit or two.
DLPOLY_ALWAYS_INLINE double lost_by_series(double x) {
    double rest = 1.0 - x * (1.0 / 8.0);
    rest = 1.0 - x * (1.0 / 7.0) * rest;
    rest = 1.0 - x * (1.0 / 6.0) * rest;
    rest = 1.0 - x * (1.0 / 5.0) * rest;
    rest = 1.0 - x * (1.0 / 4.0) * rest;
    rest = 1.0 - x * (1.0 / 3.0) * rest;
    rest = 1.0 - x * (1.0 / 2.0) * rest;
    return x * rest;
}

// Always part of their callers, so that they are compiled for the callers' instruction sets.
template <bool one_term, bool quadratic>
DLPOLY_ALWAYS_INLINE void run_weights(const HeatWeights& loop) {
    const double* DLPOLY_RESTRICT squared = loop.squared;
    const std::uint32_t* DLPOLY_RESTRICT term = loop.term;
    const HeatPair* DLPOLY_RESTRICT pairs = loop.pairs;
    double* DLPOLY_RESTRICT weight = loop.weight;
    const std::size_t count = whole_lanes(loop.count);
    const double timestep = loop.timestep;
    const double range = pairs[0].range;
    const double exponent = pairs[0].exponent;
    for (std::size_t k = 0; k < count; ++k) {
        const double closeness = 1.0 - std::sqrt(squared[k]) / (one_term ? range : pairs[term[k]].range);
        if constexpr (quadratic) {
            weight[k] = closeness * closeness * timestep;
        } else {
            weight[k] = power_of(closeness, one_term ? exponent : pairs[term[k]].exponent) * timestep;
        }
    }
}

DLPOLY_ALWAYS_INLINE void run_normals(const HeatWords& loop) {
    const std::uint32_t* DLPOLY_RESTRICT first = loop.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.second;
    const std::uint32_t* DLPOLY_RESTRICT word = loop.word;
    const std::uint32_t* DLPOLY_RESTRICT order = loop.order;
    const float* DLPOLY_RESTRICT quantiles = loop.quantiles;
    std::int32_t* DLPOLY_RESTRICT mixed = loop.mixed;
    double* DLPOLY_RESTRICT normal = loop.normal;
    const std::size_t count = whole_lanes(loop.count);
    if (const std::uint32_t* DLPOLY_RESTRICT image = loop.image; image != nullptr) {
        for (std::size_t k = 0; k < count; ++k) {
            mixed[k] = mix_words(word[first[k]], word[second[k]], image[k]);
        }
    } else {
        for (std::size_t k = 0; k < count; ++k) {
            mixed[k] = mix_words(word[first[k]], word[second[k]]);
        }
    }
    for (std::size_t k = 0; k < count; ++k) {
        const double value = NormalTable::between(quantiles, mixed[k]);
        normal[k] = order[first[k]] < order[second[k]] ? value : -value;
    }
}

template <bool one_term>
DLPOLY_ALWAYS_INLINE std::size_t run_exchange(const HeatRound& round, std::size_t begin, std::size_t end,
                                              UnusualGain* unusual) {
    const std::uint32_t* DLPOLY_RESTRICT first = round.first + begin;
    const std::uint32_t* DLPOLY_RESTRICT second = round.second + begin;
    const std::uint32_t* DLPOLY_RESTRICT term = round.term + begin;
    const double* DLPOLY_RESTRICT step_weight = round.weight + begin;
    const double* DLPOLY_RESTRICT normal = round.normal + begin;
    const HeatPair* DLPOLY_RESTRICT pairs = round.pairs;
    const double* DLPOLY_RESTRICT temperature = round.temperature;
    const double* DLPOLY_RESTRICT capacity = round.capacity;
    const double* DLPOLY_RESTRICT inverse_capacity = round.inverse_capacity;
    const HeatPair uniform = pairs[0];
    const double reference = round.reference;
    const double unit = 1.0 / reference;
    const std::size_t count = end - begin;
    const std::size_t whole = whole_lanes(count);
    Lanes of_first, of_second, capacity_of_first, capacity_of_second, inverse_of_first, inverse_of_second;
    Lanes kappa, slope, relaxation, lost, gain, new_first, new_second;
    std::uint64_t strong = 0;
    for (std::size_t k = 0; k < whole; ++k) {
        const double a = temperature[first[k]];
        const double b = temperature[second[k]];
        const double mean = 0.5 * (a + b);
        const double x = mean * unit - 1.0;
        const HeatPair& pair = one_term ? uniform : pairs[term[k]];
        const double conductivity = pair.conductivity * HeatPairs::value(pair.conduction, x);
        const bool conducts = conductivity > 0.0;
        kappa[k] = conducts ? conductivity : 0.0;
        slope[k] = conducts ? pair.conductivity * HeatPairs::slope(pair.conduction, x) / reference : 0.0;
        const double of_a = inverse_capacity[first[k]];
        const double of_b = inverse_capacity[second[k]];
        const double ratio = 0.25 * (a / b + 2.0 + b / a);
        const double both = capacity[first[k]] * capacity[second[k]];
        const double relaxed = both * (of_a + of_b) * kappa[k] * step_weight[k] * ratio;
        strong |= relaxed > gentle ? 1U : 0U;
        of_first[k] = a;
        of_second[k] = b;
        capacity_of_first[k] = capacity[first[k]];
        capacity_of_second[k] = capacity[second[k]];
        inverse_of_first[k] = of_a;
        inverse_of_second[k] = of_b;
        relaxation[k] = relaxed;
        lost[k] = lost_by_series(relaxed);
    }
    if (strong != 0) {
        for (std::size_t k = 0; k < whole; ++k) {
            const double relaxed = relaxation[k];
            const double rest = power::exponential(-relaxed);
            lost[k] = relaxed > gentle ? 1.0 - rest : lost[k];
        }
    }
    std::uint64_t others = 0;
    for (std::size_t k = 0; k < whole; ++k) {
        const double a = of_first[k];
        const double b = of_second[k];
        const double of_a = inverse_of_first[k];
        const double of_b = inverse_of_second[k];
        const double both = capacity_of_first[k] * capacity_of_second[k];
        const double energy_a = capacity_of_first[k] * a;
        const double energy_b = capacity_of_second[k] * b;
        const double mean = 0.5 * (a + b);
        const double common = 1.0 / (of_a + of_b);
        const double variance = lost[k] * (2.0 - lost[k]) * common;  // 1 − e^{−2x}
        const double drift = both * mean * (2.0 * kappa[k] + mean * slope[k]);
        double gained = lost[k] * (b - a) * common;
        gained += std::sqrt(variance * a) * std::sqrt(b) * normal[k];
        gained += 0.5 * step_weight[k] * (of_a - of_b) * drift;
        const bool acts = (kappa[k] * step_weight[k] > 0.0) & (of_a + of_b != 0.0);
        const double left = energy_a + gained;
        const bool usual = (left > 0.0) & (left < energy_a + energy_b) & (of_a != 0.0) & (of_b != 0.0);
        others |= (usual | !acts) ? 0U : 1U;
        const double given = usual & acts ? gained : 0.0;
        gain[k] = acts ? gained : 0.0;
        new_first[k] = a + given * of_a;
        new_second[k] = b - given * of_b;
        lost[k] = usual | !acts ? 0.0 : 1.0;
    }
    for (std::size_t k = 0; k < count; ++k) {
        round.temperature[first[k]] = new_first[k];
        round.temperature[second[k]] = new_second[k];
    }
    std::size_t found = 0;
    if (others != 0) {
        for (std::size_t k = 0; k < count; ++k) {
            if (lost[k] != 0.0) {
                unusual[found++] = {begin + k, gain[k]};
            }
        }
    }
    return found;
}

#define DLPOLY_LOOPS_FOR(set, attribute)                                                                              \
    attribute void set##_powers(const HeatWeights& loop) { run_weights<false, false>(loop); }                         \
    attribute void set##_squares(const HeatWeights& loop) { run_weights<false, true>(loop); }                         \
    attribute void set##_one_power(const HeatWeights& loop) { run_weights<true, false>(loop); }                       \
    attribute void set##_one_square(const HeatWeights& loop) { run_weights<true, true>(loop); }                       \
    attribute void set##_normals(const HeatWords& loop) { run_normals(loop); }                                        \
    attribute std::size_t set##_many(const HeatRound& r, std::size_t begin, std::size_t end, UnusualGain* out) {      \
        return run_exchange<false>(r, begin, end, out);                                                               \
    }                                                                                                                 \
    attribute std::size_t set##_one(const HeatRound& r, std::size_t begin, std::size_t end, UnusualGain* out) {       \
        return run_exchange<true>(r, begin, end, out);                                                                \
    }                                                                                                                 \
    constexpr HeatExchangeLoops set##_loops{{{&set##_powers, &set##_squares}, {&set##_one_power, &set##_one_square}}, \
                                            &set##_normals,                                                           \
                                            {&set##_many, &set##_one}};

DLPOLY_LOOPS_FOR_EVERY_SET(DLPOLY_LOOPS_FOR)

}  // namespace

const HeatExchangeLoops& heat_exchange_loops() { return DLPOLY_CHOSEN_LOOPS; }

}  // namespace dlpoly
