// The loops over a batch that internal temperatures add to the pair forces: what they change of repulsion, drag and
// noise, and the heat of drag and noise. Compiled for every instruction set, as the pair laws are; all give the same
// bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meso/heat_pairs.hpp"

namespace dlpoly {

// Of the beads of a batch; all arrays hold whole lanes, and `count` is a multiple of them.
struct HeatBatch {
    const std::uint32_t* first;  // sorted indices
    const std::uint32_t* second;
    const double* squared;  // distances
    std::size_t count;
};

// In sorted order.
struct HeatBead {
    double temperature;
    double inverse_capacity;  // 0 where the temperature is held
};

// factor[k] = T̄/T_ref.
struct RepulsionOfHeat {
    HeatBatch batch;
    const HeatBead* beads;
    double reference;
    double* factor;
};

// Changes drag and noise of a pair of T_ref to those of its temperatures.
struct MotionOfHeat {
    HeatBatch batch;
    const HeatBead* beads;
    const HeatPair* pair;
    double reference;
    double weight_exponent;  // at T_ref
    double given_exponent;   // of the drag that is changed
    double cutoff;           // of the drag
    double* drag;
    double* noise;
};

// A bead whose drag and noise become heat, in sorted order.
struct HeatedBead {
    double before[3];  // velocity that the drag was computed from
    double change[3];  // of half a kick
    double mass;
    double capacity;
    double temperature;
};

// heat[k] = what each of two beads is given, on a grid, and ahead[k] what both lose by the next half kick. `size` tells
// those that are beyond the grid or no numbers, in units of the grid's largest.
struct HeatOfMotion {
    HeatBatch batch;
    const HeatedBead* beads;
    const double* dx;
    const double* dy;
    const double* dz;
    const double* drag;
    const double* noise;
    double timestep;
    double kicked;
    double scale;
    std::int64_t* heat;
    std::int64_t* ahead;
    double* size;
};

struct HeatMotionLoops {
    void (*repulsion)(const RepulsionOfHeat&);
    // By what depends on temperature besides σ²: nothing, the weight, γ, both.
    void (*motion[4])(const MotionOfHeat&);
    // Return whether all heats fit the grid.
    bool (*conserving)(const HeatOfMotion&);
    bool (*lammps)(const HeatOfMotion&);  // leaves `ahead` as it is
};

const HeatMotionLoops& heat_motion_loops();

}  // namespace dlpoly
