// Constants of kinds and of pairs of kinds, on the scale of the records (see arguments.hpp).
#pragma once

#include <array>

#include "fast/arguments.hpp"
#include "fast/kinds.hpp"
#include "fast/scheme.hpp"
#include "fast/units.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly::fast {

template <class Record>
struct Constants {
    using Arithmetic = typename Record::Arithmetic;

    std::array<PairRow<Arithmetic>, most_kinds> rows{};
    // Of thermostat steps in the middle of the drift, which take noise and drag in passes of their own.
    std::array<PairRow<Arithmetic>, most_kinds> noise_rows{};
    std::array<PairRow<Arithmetic>, most_kinds> drag_rows{};
    std::array<PairRow<Arithmetic>, most_kinds> motion_rows{};  // both at once
    std::array<Arithmetic, most_kinds> inverse_mass{};
    std::array<Arithmetic, most_kinds> drift{};
    std::array<Arithmetic, most_kinds> half_drift{};
};

template <class Record>
Constants<Record> make_constants(const Kinds& kinds, const PairTable& table, const Scheme& scheme, const Units& units);

}  // namespace dlpoly::fast
