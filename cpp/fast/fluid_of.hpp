// The fast path for one kind of record.
//
// Its parts: the records in the order of the cells and their sorting (sorted_beads.hpp), the constants of pairs
// (constants.hpp), bonded terms and charges (added_forces.hpp). What is here takes over a state, has the passes made
// step by step (fluid.cpp), and gives the state back (fluid_state.cpp).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/random.hpp"
#include "core/state.hpp"
#include "fast/added_forces.hpp"
#include "fast/arguments.hpp"
#include "fast/constants.hpp"
#include "fast/fluid.hpp"
#include "fast/kinds.hpp"
#include "fast/scheme.hpp"
#include "fast/sorted_beads.hpp"
#include "fast/units.hpp"

namespace dlpoly::fast {

template <class Record>
class FluidOf final : public Fluid {
  public:
    FluidOf(const State& state, const PairTable& table, const StepSettings& settings, const Passes& passes,
            double cell_width);

    void set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species) override {
        added_.set_bonded(terms, totals, std::move(species));
    }
    void set_charges(ChargeForces& charges, ChargeTotals& totals) override { added_.set_charges(charges, totals); }
    void start(State& state, const StepSettings& settings, PairTotals& totals) override;
    void run(State& state, const StepSettings& settings, std::uint64_t steps, PairTotals& totals) override;

  private:
    using Fixed = typename Record::Fixed;
    using Arithmetic = typename Record::Arithmetic;

    // fluid_state.cpp
    void take(State& state, const StepSettings& settings, bool with_impulses);
    void give_motion(State& state);
    void give_forces(State& state);
    [[noreturn]] void stop(State& state, std::uint64_t lost, std::uint64_t steps);
    [[nodiscard]] Matrix3 half_step_kinetic() const;

    // fluid.cpp
    void passes(State& state, const StepSettings& settings, std::uint64_t steps, bool start, PairTotals& totals);
    void thermostat_passes(PassArguments<Record>& a, const StepSettings& settings, std::size_t part, std::size_t parts,
                           std::uint64_t step, bool observe);
    PassArguments<Record> arguments(State& state);
    void observe_totals(PairTotals& totals) const;
    [[nodiscard]] int thread_count() const;

    [[nodiscard]] Pass<Record> pass_of(Variant variant) const {
        if constexpr (std::is_same_v<Record, MixedRecord>) {
            return passes_.mixed(variant);
        } else {
            return passes_.in_double(variant);
        }
    }

    // The random words that a pass makes from now on belong to this step.
    static void set_word_key(PassArguments<Record>& a, const StepSettings& settings, std::uint64_t step) {
        const auto key = bead_word_key(settings.seed, step);
        std::copy(key.begin(), key.end(), a.word_key);
    }

    const Passes& passes_;
    Kinds kinds_;
    Scheme scheme_;
    Units units_;
    Constants<Record> constants_;
    SortedBeads<Record> beads_;
    std::int32_t cells_a_block_;
    AddedForces<Record> added_;
    std::vector<double> observed_;  // observed_numbers a row of cells
};

}  // namespace dlpoly::fast
