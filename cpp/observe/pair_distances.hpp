// Histogram of pair distances by pair of species, the counts behind g(r).
#pragma once

#include <cstdint>
#include <vector>

#include "cells/link_cells.hpp"
#include "core/box.hpp"
#include "core/particles.hpp"

namespace dlpoly {

class PairDistances {
  public:
    PairDistances(std::int32_t species, double range, std::int32_t bins);

    // Adds every pair (each image within the range counts) of the present configuration.
    void sample(const Box& box, const Particles& particles);

    // Pairs counted once, index [(a · species + b) · bins + bin] with a ≤ b.
    [[nodiscard]] const std::vector<std::int64_t>& counts() const noexcept { return counts_; }
    [[nodiscard]] std::int64_t samples() const noexcept { return samples_; }
    // Sum of the cell's volumes over the samples.
    [[nodiscard]] double volumes() const noexcept { return volumes_; }
    void restore(std::vector<std::int64_t> counts, std::int64_t samples, double volumes);

  private:
    std::int32_t species_;
    double range_;
    std::int32_t bins_;
    std::int64_t samples_ = 0;
    double volumes_ = 0.0;
    std::vector<std::int64_t> counts_;
    LinkCells cells_;
};

}  // namespace dlpoly
