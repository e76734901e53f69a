// Weights of drag and noise with another exponent than 2, over whole batches, for the best instruction set that the
// processor has; all sets give the same bits.
#pragma once

#include <cstddef>

namespace dlpoly {

struct WeightLoops {
    // power[k] = (1 − r/cutoff)^exponent, 0 beyond the cutoff; `count` is a multiple of batch_lanes.
    void (*common)(const double* distance_squared, double cutoff, double exponent, double* power, std::size_t count);
};

const WeightLoops& weight_loops();

}  // namespace dlpoly
