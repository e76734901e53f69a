// The loops of heat over batches (see heat_motion_loops.hpp).
#include "meso/heat_motion_loops.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/compiler.hpp"
#include "core/exact_sum.hpp"
#include "core/power.hpp"
#include "forces/pair_batch.hpp"
#include "forces/pair_phases.hpp"

namespace dlpoly {

namespace {

// Added to a number below 2^51 it leaves the number, rounded half to even, in the low bits.
constexpr double rounding_offset = 0x1.8p52;

// Numbers that arithmetic over whole lanes is done with.
struct Lanes {
    alignas(64) double values[batch_capacity + batch_lanes];

    DLPOLY_ALWAYS_INLINE double& operator[](std::size_t k) { return values[k]; }
};

DLPOLY_ALWAYS_INLINE std::int64_t to_grid(double value) {
    return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(value + rounding_offset) -
                                     std::bit_cast<std::uint64_t>(rounding_offset));
}

DLPOLY_ALWAYS_INLINE std::size_t whole_lanes(const HeatBatch& batch) { return batch.count / batch_lanes * batch_lanes; }

// Always part of their callers, so that they are compiled for the callers' instruction sets.
DLPOLY_ALWAYS_INLINE void run_repulsion(const RepulsionOfHeat& loop) {
    const std::uint32_t* DLPOLY_RESTRICT first = loop.batch.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.batch.second;
    const HeatBead* DLPOLY_RESTRICT beads = loop.beads;
    double* DLPOLY_RESTRICT factor = loop.factor;
    const std::size_t count = whole_lanes(loop.batch);
    const double reference = loop.reference;
    for (std::size_t k = 0; k < count; ++k) {
        factor[k] = 0.5 * (beads[first[k]].temperature + beads[second[k]].temperature) / reference;
    }
}

template <bool weight_varies, bool drag_varies>
DLPOLY_ALWAYS_INLINE void run_motion(const MotionOfHeat& loop) {
    const std::uint32_t* DLPOLY_RESTRICT first = loop.batch.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.batch.second;
    const double* DLPOLY_RESTRICT squared = loop.batch.squared;
    const HeatBead* DLPOLY_RESTRICT beads = loop.beads;
    double* DLPOLY_RESTRICT drag = loop.drag;
    double* DLPOLY_RESTRICT noise = loop.noise;
    const std::size_t count = whole_lanes(loop.batch);
    const HeatPair pair = *loop.pair;
    const double unit = 1.0 / loop.reference;
    const double exponent = loop.weight_exponent;
    const double given = loop.given_exponent;
    const double cutoff = loop.cutoff;
    Lanes of_first, of_second, capacity_of_first, capacity_of_second;
    for (std::size_t k = 0; k < count; ++k) {
        of_first[k] = beads[first[k]].temperature;
        of_second[k] = beads[second[k]].temperature;
        capacity_of_first[k] = beads[first[k]].inverse_capacity;
        capacity_of_second[k] = beads[second[k]].inverse_capacity;
    }
    for (std::size_t k = 0; k < count; ++k) {
        const double a = of_first[k];
        const double b = of_second[k];
        double factor = 1.0;
        double log_slope = 0.0;
        if constexpr (weight_varies || drag_varies) {
            const double x = 0.5 * (a + b) * unit - 1.0;
            if constexpr (weight_varies) {
                const double closeness = 1.0 - std::sqrt(squared[k]) / cutoff;
                const bool some = closeness > 0.0;
                const double logarithm = power::logarithm(some ? closeness : 1.0);
                const double wanted =
                    std::max(HeatPairs::least_weight_exponent, exponent * HeatPairs::value(pair.weight, x));
                const double change = power::exponential((wanted - given) * logarithm);
                factor = some ? change : 0.0;  // outside the drag's own range drag and noise are 0 already
                log_slope = exponent * HeatPairs::slope(pair.weight, x) * logarithm;
            }
            if constexpr (drag_varies) {
                const double of_drag = HeatPairs::value(pair.drag, x);
                factor *= std::max(0.0, of_drag);
                log_slope += HeatPairs::slope(pair.drag, x) / of_drag;
            }
            log_slope *= unit;
        }
        const double more =
            1.0 + HeatPairs::drag_of_noise(a, b, capacity_of_first[k], capacity_of_second[k], log_slope);
        drag[k] *= factor * more;
        noise[k] *= std::sqrt(factor * HeatPairs::thermal_energy(a, b) * unit);
    }
}

// −γ w^D u² and the rest that LAMMPS has, for half of a pair.
DLPOLY_ALWAYS_INLINE bool run_lammps(const HeatOfMotion& loop) {
    const std::uint32_t* DLPOLY_RESTRICT first = loop.batch.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.batch.second;
    const double* DLPOLY_RESTRICT squared = loop.batch.squared;
    const HeatedBead* DLPOLY_RESTRICT beads = loop.beads;
    const double* DLPOLY_RESTRICT dx = loop.dx;
    const double* DLPOLY_RESTRICT dy = loop.dy;
    const double* DLPOLY_RESTRICT dz = loop.dz;
    const double* DLPOLY_RESTRICT drag = loop.drag;
    const double* DLPOLY_RESTRICT noise = loop.noise;
    std::int64_t* DLPOLY_RESTRICT heat = loop.heat;
    double* DLPOLY_RESTRICT size = loop.size;
    const std::size_t count = whole_lanes(loop.batch);
    const double timestep = loop.timestep;
    const double root = std::sqrt(timestep);
    const double scale = loop.scale;
    Lanes projection, of_first, of_second, capacity, mass;
    for (std::size_t k = 0; k < count; ++k) {
        const HeatedBead& a = beads[first[k]];
        const HeatedBead& b = beads[second[k]];
        projection[k] = dx[k] * (a.before[0] - b.before[0]) + dy[k] * (a.before[1] - b.before[1]) +
                        dz[k] * (a.before[2] - b.before[2]);
        of_first[k] = a.temperature;
        of_second[k] = b.temperature;
        capacity[k] = a.capacity + b.capacity;
        mass[k] = 0.5 * (a.mass + b.mass);
    }
    std::uint64_t beyond = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double before = projection[k];
        // γ w^D is −drag r²/(r·v), unless the pair does not move: then noise, whose mean square is known, is left out.
        const double gamma = before != 0.0 ? -drag[k] * squared[k] / before : 0.0;
        const double variance = 2.0 * gamma * HeatPairs::thermal_energy(of_first[k], of_second[k]);
        const double power = -drag[k] * before - variance / mass[k] - noise[k] * before * root;
        const double given = timestep * power / capacity[k] * scale;
        const double value = first[k] == second[k] ? 0.0 : given;
        heat[k] = to_grid(value);
        size[k] = std::abs(value) * (1.0 / largest_term);
        beyond |= size[k] < 1.0 ? 0U : 1U;
    }
    return beyond == 0;
}

DLPOLY_ALWAYS_INLINE bool run_conserving(const HeatOfMotion& loop) {
    const std::uint32_t* DLPOLY_RESTRICT first = loop.batch.first;
    const std::uint32_t* DLPOLY_RESTRICT second = loop.batch.second;
    const HeatedBead* DLPOLY_RESTRICT beads = loop.beads;
    const double* DLPOLY_RESTRICT dx = loop.dx;
    const double* DLPOLY_RESTRICT dy = loop.dy;
    const double* DLPOLY_RESTRICT dz = loop.dz;
    const double* DLPOLY_RESTRICT drag = loop.drag;
    const double* DLPOLY_RESTRICT noise = loop.noise;
    std::int64_t* DLPOLY_RESTRICT heat = loop.heat;
    std::int64_t* DLPOLY_RESTRICT ahead = loop.ahead;
    double* DLPOLY_RESTRICT size = loop.size;
    const std::size_t count = whole_lanes(loop.batch);
    const double half = 0.5 * loop.timestep;
    const double kicked = loop.kicked + 0.5;
    const double scale = loop.scale;
    Lanes velocity, change;
    for (std::size_t k = 0; k < count; ++k) {
        const HeatedBead& a = beads[first[k]];
        const HeatedBead& b = beads[second[k]];
        velocity[k] = dx[k] * (a.before[0] - b.before[0]) + dy[k] * (a.before[1] - b.before[1]) +
                      dz[k] * (a.before[2] - b.before[2]);
        change[k] = dx[k] * (a.change[0] - b.change[0]) + dy[k] * (a.change[1] - b.change[1]) +
                    dz[k] * (a.change[2] - b.change[2]);
    }
    std::uint64_t beyond = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double push = half * (drag[k] + noise[k]);
        const double later = push * (velocity[k] + kicked * change[k]);  // over the velocities from v to v + change
        const double given = 0.5 * (-push * (velocity[k] + 0.5 * change[k]) - later) * scale;
        const bool pair = first[k] != second[k];
        const double value = pair ? given : 0.0;
        const double to_come = pair ? later * scale : 0.0;
        heat[k] = to_grid(value);
        ahead[k] = to_grid(to_come);
        // Both, because the greater of one number and none may be the number.
        size[k] = (std::abs(value) + std::abs(to_come)) * (1.0 / largest_term);
        beyond |= size[k] < 1.0 ? 0U : 1U;
    }
    return beyond == 0;
}

#define DLPOLY_LOOPS_FOR(set, attribute)                                                             \
    attribute void set##_repulsion(const RepulsionOfHeat& loop) { run_repulsion(loop); }             \
    attribute void set##_plainly(const MotionOfHeat& loop) { run_motion<false, false>(loop); }       \
    attribute void set##_weight(const MotionOfHeat& loop) { run_motion<true, false>(loop); }         \
    attribute void set##_drag(const MotionOfHeat& loop) { run_motion<false, true>(loop); }           \
    attribute void set##_both(const MotionOfHeat& loop) { run_motion<true, true>(loop); }            \
    attribute bool set##_conserving(const HeatOfMotion& loop) { return run_conserving(loop); }       \
    attribute bool set##_lammps(const HeatOfMotion& loop) { return run_lammps(loop); }               \
    constexpr HeatMotionLoops set##_loops{&set##_repulsion,                                          \
                                          {&set##_plainly, &set##_weight, &set##_drag, &set##_both}, \
                                          &set##_conserving,                                         \
                                          &set##_lammps};

DLPOLY_LOOPS_FOR_EVERY_SET(DLPOLY_LOOPS_FOR)

}  // namespace

const HeatMotionLoops& heat_motion_loops() { return DLPOLY_CHOSEN_LOOPS; }

}  // namespace dlpoly
