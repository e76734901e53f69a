// The two loops over a batch that many-body DPD adds: what a pair adds to the local densities of its beads, and the
// force of these densities. Compiled for every instruction set, as the pair laws are; all give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dlpoly {

// W(r) of a batch's pairs, rounded to a grid. All arrays hold whole lanes, and `count` is a multiple of them.
struct DensityLoop {
    const double* squared;  // distances
    std::int64_t* weights;
    std::size_t count;
    double inverse_range;
    double exponent;  // n
    double height;    // W(0), in units of the grid
};

// Adds push (φ_i + φ_j)(1 − r/r_d)^(n − 1)/r to a batch's factors.
struct RepulsionLoop {
    const double* squared;
    const std::uint32_t* first;  // sorted indices
    const std::uint32_t* second;
    const double* response;  // φ, in sorted order
    double* conservative;
    std::size_t count;
    double inverse_range;
    double exponent;  // n
    double push;
};

struct ManyBodyLoops {
    void (*quadratic_density)(const DensityLoop&);  // n = 2
    void (*power_density)(const DensityLoop&);
    void (*lucy_density)(const DensityLoop&);
    void (*linear_repulsion)(const RepulsionLoop&);  // n = 2
    void (*power_repulsion)(const RepulsionLoop&);
};

// Those for the instruction set of the pair loop's other phases.
const ManyBodyLoops& many_body_loops();

}  // namespace dlpoly
