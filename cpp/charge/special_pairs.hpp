// Pairs of charges that the pair sum leaves out because a bonded term takes their place: Ewald's sum over reciprocal
// vectors holds them all the same, so it is taken away here, and 1-4 pairs act times a factor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "charge/accumulator.hpp"
#include "charge/charges.hpp"
#include "charge/kernel.hpp"
#include "charge/screening.hpp"
#include "core/box.hpp"

namespace dlpoly::charge {

class SpecialPairs {
  public:
    struct Pair {
        std::uint32_t i, j;  // places in the list of charges
        bool excluded;
        double scale;  // of the Coulomb energy that is added
    };

    // screening: what to take away from excluded pairs, nothing without it. kernel, up to its range: what scaled pairs
    // feel.
    SpecialPairs(std::size_t charges, std::vector<Pair> pairs, std::optional<Screening> screening, const Kernel& kernel,
                 double range);

    [[nodiscard]] bool empty() const noexcept { return pairs_.empty(); }

    void add_to(const Box& box, const Array3N& positions, const Charges& charges, std::int64_t* sums,
                Accumulator& total) const;
    void add_curvature(const Box& box, const Array3N& positions, const Charges& charges, Accumulator& total) const;

  private:
    std::vector<Pair> pairs_;
    std::vector<std::size_t> start_;     // by charge, into touching_
    std::vector<std::size_t> touching_;  // each charge's pairs
    std::optional<Screening> screening_;
    const Kernel& kernel_;
    double range_;
};

}  // namespace dlpoly::charge
