// A batch of accepted pairs that are handled together: arrays of equal length, so that every phase (law, drag and
// noise, rounding, summation) is a short loop over plain numbers. All pairs of a batch belong to one entry of the pair
// table. Plain arrays and no member functions, because the phases are compiled for several instruction sets.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace dlpoly {

inline constexpr size_t batch_capacity = 128;
inline constexpr size_t batch_lanes = 8;  // phases may read and write this many entries past the end

template <class T>
struct BatchArray {
    alignas(64) T values[batch_capacity + batch_lanes];
};

// Consecutive pairs of a batch that share their first bead.
struct PairRun {
    uint32_t bead;
    uint32_t begin;
    uint32_t end;
};

struct PairBatch {
    size_t size = 0;
    size_t runs = 0;
    uint32_t term = 0;           // the entry of the pair table
    double reach_squared = 0.0;  // all pairs are closer than this
    BatchArray<uint32_t> i;      // sorted index of the first bead
    BatchArray<uint32_t> j;      // sorted index of the second bead
    BatchArray<uint32_t> image;  // number of the lattice vector, filled only where pairs have several images
    BatchArray<double> dx;       // r_i − r_j to the image met
    BatchArray<double> dy;
    BatchArray<double> dz;
    BatchArray<double> distance_squared;
    BatchArray<PairRun> run;
};

// A force in grid units; the fourth word makes it one aligned vector.
struct alignas(32) GridForce {
    int64_t x, y, z, unused;
};

// What the phases compute for each pair of a batch; the first four are factors of the vector r_i − r_j.
struct BatchResult {
    BatchArray<double> energy;
    BatchArray<double> conservative;
    BatchArray<double> drag;
    BatchArray<double> noise;
    BatchArray<GridForce> force;
};

}  // namespace dlpoly
