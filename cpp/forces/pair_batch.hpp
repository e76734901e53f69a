// A batch of accepted pairs that one kernel handles together: arrays of equal length, so that every phase (law, drag
// and noise, summation) is a short loop over plain numbers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dlpoly {

inline constexpr std::size_t batch_capacity = 256;

template <class T>
using BatchArray = std::array<T, batch_capacity>;

struct PairBatch {
    std::size_t size = 0;
    BatchArray<std::uint32_t> i;     // sorted index of the first bead
    BatchArray<std::uint32_t> j;     // sorted index of the second bead
    BatchArray<std::uint32_t> term;  // which entry of the pair table
    BatchArray<std::uint8_t> image;  // tells several images of one pair apart, for the noise
    BatchArray<double> dx;           // r_i − r_j to the image met
    BatchArray<double> dy;
    BatchArray<double> dz;
    BatchArray<double> distance_squared;
};

// What the phases compute for each pair of a batch, all as factors of the vector r_i − r_j.
struct BatchResult {
    BatchArray<double> energy;
    BatchArray<double> conservative;
    BatchArray<double> drag;
    BatchArray<double> noise;
};

}  // namespace dlpoly
