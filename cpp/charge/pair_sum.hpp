// The part of the electrostatics that acts between pairs of charged beads within the cutoff.
#pragma once

#include <cstdint>
#include <vector>

#include "cells/link_cells.hpp"
#include "charge/accumulator.hpp"
#include "charge/charges.hpp"
#include "charge/kernel.hpp"
#include "core/box.hpp"
#include "forces/exclusions.hpp"

namespace dlpoly::charge {

class PairSum {
  public:
    // Pairs of `excluded` (places in the list of charges) are left out in the image in which they are nearest.
    PairSum(const Kernel& kernel, const Exclusions& excluded, double cutoff)
        : kernel_(kernel), excluded_(excluded), squared_cutoff_(cutoff * cutoff), cutoff_(cutoff) {}

    // Sorts the charges into link cells.
    void sort(const Box& box, const Array3N& positions) { cells_.build(box, positions, cutoff_); }

    // Adds to `sums`, 3 grid units a charge.
    void add_to(const Box& box, const Array3N& positions, const Charges& charges, std::int64_t* sums,
                Accumulator& total);

    // Adds q_i q_j ∇²u, times how many of the two can move, to the energy of `total`.
    void add_curvature(const Box& box, const Array3N& positions, const Charges& charges, Accumulator& total);

  private:
    struct Walk;

    template <class Finish>
    void visit(Walk& walk, const Finish& finish);
    template <class Finish>
    void visit_row(Walk& walk, std::int32_t row, Accumulator& own, const Finish& finish) const;

    const Kernel& kernel_;
    const Exclusions& excluded_;
    double squared_cutoff_, cutoff_;
    LinkCells cells_;
};

}  // namespace dlpoly::charge
