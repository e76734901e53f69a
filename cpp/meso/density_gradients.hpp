// Σ ψ''_i |∇_k ρ̄_i|² of many-body DPD: the part of its second derivatives that pairs alone cannot give.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/exact_sum.hpp"
#include "forces/pair_worker.hpp"

namespace dlpoly {

struct DensityPair;

class DensityGradients final : public PairVisitor {
  public:
    // By sorted index: ψ'' and which beads can move. The pairs are by entry of the pair table. All must outlive this.
    DensityGradients(const std::vector<DensityPair>& pairs, const std::vector<double>& second,
                     const std::vector<std::uint8_t>& mobile, int threads);

    [[nodiscard]] bool wants_factors() const override { return false; }
    [[nodiscard]] double reach_squared(std::uint32_t term, double of_table) const override;
    void visit(const PairBatch& batch, const double* factors, const std::uint32_t* order, int thread) override;

    // After all pairs were shown; `order` holds their ids.
    [[nodiscard]] double sum(const std::vector<std::uint32_t>& order);

  private:
    // What one image of j does to the density of i, as a vector on a grid.
    struct Slope {
        std::uint32_t i, j;  // i < j
        std::array<std::int64_t, 3> vector;
    };

    const std::vector<DensityPair>& pairs_;
    const std::vector<double>& second_;
    const std::vector<std::uint8_t>& mobile_;
    double scale_ = 1.0;
    std::vector<std::array<std::int64_t, 3>> own_;  // −∇_i ρ̄_i
    std::vector<std::vector<Slope>> slopes_;        // by thread
};

}  // namespace dlpoly
