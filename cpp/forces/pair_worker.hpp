// What a force evaluation is asked for, and what one thread keeps while it walks the pairs.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cells/link_cells.hpp"
#include "core/exact_sum.hpp"
#include "forces/pair_batch.hpp"

namespace dlpoly {

// What one force evaluation is asked for.
struct ForceRequest {
    bool observe = false;  // also energies and stress
    bool drag = false;     // also drag and noise, from the velocities given and this step's noise
    double weight_exponent = 2.0;
    double inverse_root_timestep = 0.0;  // 1/√Δt
    bool gaussian_noise = false;         // one Philox4x32-10 a pair instead of the mix of two beads' words
    std::uint64_t seed = 0;
    std::uint64_t step = 0;
};

// What one thread owns while it walks rows of cells: batches, partial totals and the worst pair it met.
struct PairWorker {
    std::vector<PairBatch> batches;
    BatchResult result;
    std::vector<CellImage> neighbours;
    ForceRequest request;
    double scale = 0.0;
    double energy_scale = 0.0;
    WideSum energy;
    std::array<WideSum, 9> conservative, drag, noise;
    // Largest force term and largest energy or virial term met, in units of the largest term allowed; above 1 the sums
    // must be repeated on a coarser grid. Apart, so that observing a step never changes its forces.
    double largest = 0.0;
    double largest_energy = 0.0;
    std::uint32_t largest_i = 0, largest_j = 0;
    double largest_distance = 0.0;

    void reset(std::size_t kinds, const ForceRequest& asked, int exponent, int energy_exponent) {
        batches.resize(kinds);
        for (PairBatch& batch : batches) {
            batch.size = 0;
        }
        request = asked;
        scale = std::ldexp(1.0, exponent);
        energy_scale = std::ldexp(1.0, energy_exponent);
        energy = WideSum();
        conservative = drag = noise = {};
        largest = 0.0;
        largest_energy = 0.0;
    }
};

}  // namespace dlpoly
