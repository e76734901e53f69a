// The steps of the fast path (see fluid_of.hpp).
#include "fast/fluid.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>

#include "core/threads.hpp"
#include "fast/aligned_array.hpp"
#include "fast/fluid_of.hpp"

namespace dlpoly::fast {

namespace {

// Beads a thread should have before another one pays for the waiting at the end of each step.
constexpr std::size_t beads_a_thread = 1500;

// Edge of a cube that holds two to three beads on average. Cells of a thin fluid are this wide: with fewer beads in a
// cell the vectors of the search stay empty, and visiting cells would cost more than the candidates they save.
double spacing(const State& state) {
    return std::cbrt(2.5 * state.box.volume() / static_cast<double>(state.particles.count()));
}

template <class Record>
Grid grid_of(const State& state, const PairTable& table, double cell_width) {
    return make_grid(state.box.cell().diagonal(), table.range(), std::max({cell_width, table.range(), spacing(state)}),
                     static_cast<int>(8 * sizeof(typename Record::Fixed)));
}

std::int32_t cells_a_block(std::size_t beads, const Grid& grid) {
    return candidates_of_block(2.0, static_cast<double>(beads) / grid.cells()) <= usual_candidates ? 2 : 1;
}

}  // namespace

template <class Record>
FluidOf<Record>::FluidOf(const State& state, const PairTable& table, const StepSettings& settings, const Passes& passes,
                         double cell_width)
    : passes_(passes),
      kinds_(find_kinds(state.particles, most_kinds)),
      scheme_(make_scheme(table, settings)),
      units_(make_units<Record>(state.box.cell().diagonal(), momentum_range(kinds_, table, settings.thermal_energy))),
      constants_(make_constants<Record>(kinds_, table, scheme_, units_)),
      beads_(grid_of<Record>(state, table, cell_width), static_cast<std::size_t>(state.particles.count()),
             scheme_.middle || scheme_.predicts, scheme_.predicts),
      cells_a_block_(cells_a_block(beads_.count(), beads_.grid())),
      added_(units_, settings.timestep, table) {}

template <class Record>
PassArguments<Record> FluidOf<Record>::arguments(State& state) {
    PassArguments<Record> a{};
    beads_.describe(a);
    added_.describe(a);
    a.cells_a_block = cells_a_block_;
    const Vector3 length = units_.edges * std::ldexp(1.0, -static_cast<int>(8 * sizeof(Fixed)));
    a.metric_x = static_cast<Arithmetic>(length[0] * length[0]);
    a.metric_y = static_cast<Arithmetic>(length[1] * length[1]);
    a.metric_z = static_cast<Arithmetic>(length[2] * length[2]);
    a.rows = constants_.rows.data();
    a.inverse_mass = constants_.inverse_mass.data();
    a.drift = constants_.drift.data();
    a.images = state.particles.image.data();
    a.stage = scheme_.predicts ? Stage::predict : Stage::advance;
    a.prediction = static_cast<Arithmetic>(scheme_.prediction);
    return a;
}

template <class Record>
int FluidOf<Record>::thread_count() const {
    const auto useful = static_cast<int>(std::max<std::size_t>(1, beads_.count() / beads_a_thread));
    return std::min({thread_limit(), useful, beads_.grid().rows()});
}

// Drag and noise at the positions in the middle of a drift, and its second half; see integrate/middle.hpp for the
// formulas. Called by all threads together.
template <class Record>
void FluidOf<Record>::thermostat_passes(PassArguments<Record>& a, const StepSettings& settings, std::size_t part,
                                        std::size_t parts, std::uint64_t step, bool observe) {
    beads_.sort(part, parts, nullptr);
    const auto [begin, end] = beads_.share(a, part, parts);
    if (observe) {
        beads_.order_cells(begin, end);
#ifdef _OPENMP
#pragma omp barrier
#endif
    }
    std::int64_t* const bonded = a.bonded;
    const auto one_kind = kinds_.list.size() == 1;
    const Pass<Record> pass = pass_of({one_kind, true, false, false});
    const Pass<Record> watched = pass_of({one_kind, true, true, false});
    a.bonded = nullptr;
    a.drift = constants_.half_drift.data();
    set_word_key(a, settings, step);
    const auto exchange = [&] {
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
        beads_.exchange();
        beads_.refresh(a);
    };
    if (settings.passes == 1) {
        a.rows = constants_.motion_rows.data();
        a.stage = Stage::advance;
        (observe ? watched : pass)(a, begin, end);
    } else {
        a.rows = constants_.noise_rows.data();
        a.stage = settings.passes == 2 ? Stage::noise_alone : Stage::noise;
        (observe ? watched : pass)(a, begin, end);
        exchange();
        a.rows = constants_.drag_rows.data();
        if (settings.passes == 3) {
            a.stage = Stage::drag;
            pass(a, begin, end);
            exchange();
        }
        a.stage = Stage::advance_held;
        (observe ? watched : pass)(a, begin, end);
    }
#ifdef _OPENMP
#pragma omp barrier
#endif
    a.stage = Stage::advance;
    a.rows = constants_.rows.data();
    a.bonded = bonded;
}

template <class Record>
void FluidOf<Record>::passes(State& state, const StepSettings& settings, std::uint64_t steps, bool start,
                             PairTotals& totals) {
    const bool one_kind = kinds_.list.size() == 1;
    const bool drag = scheme_.has_drag && !scheme_.middle;
    const Pass<Record> inner = pass_of({one_kind, drag, false, false});
    const Pass<Record> last = pass_of({one_kind, drag, true, true});
    observed_.assign(static_cast<std::size_t>(beads_.grid().rows()) * observed_numbers, 0.0);
    std::uint64_t overflow = 0;
    std::atomic<std::uint64_t> lost{0};  // the step of this call in which a momentum left its range
    const int asked = thread_count();
    std::size_t parts = 1;
    added_.restart(asked);
#ifdef _OPENMP
#pragma omp parallel num_threads(asked)
#endif
    {
        const auto part = static_cast<std::size_t>(thread_number());
#ifdef _OPENMP
#pragma omp single
        parts = static_cast<std::size_t>(omp_get_num_threads());
#endif
        added_.prepare(parts);
        PassArguments<Record> a = arguments(state);
        a.observed = observed_.data();
        AlignedArray<std::uint8_t> workspace(workspace_bytes);
        a.workspace = workspace.data();
        for (std::uint64_t k = 1; k <= steps; ++k) {
            if (!start && scheme_.thermostat_due(state.step + k)) {
                thermostat_passes(a, settings, part, parts, state.step + k, k == steps);
            }
            beads_.sort(part, parts, added_.end() > 0 ? &added_ : nullptr);
            if (!added_.compute(state, part, parts, state.step + k, k == steps)) {
                break;
            }
            const auto [begin, end] = beads_.share(a, part, parts);
            if (k == steps) {
                beads_.order_cells(begin, end);
#ifdef _OPENMP
#pragma omp barrier
#endif
            }
            a.drift =
                scheme_.thermostat_due(state.step + k + 1) ? constants_.half_drift.data() : constants_.drift.data();
            set_word_key(a, settings, state.step + k + 1);
            (k < steps ? inner : last)(a, begin, end);
            if (a.overflow != 0) {
                lost = k;
            }
#ifdef _OPENMP
#pragma omp barrier
#endif
            if (lost != 0) {
                break;  // in all threads: they see it after the barrier, and none goes on to set it again
            }
        }
#ifdef _OPENMP
#pragma omp critical
#endif
        overflow |= a.overflow;
    }
    const bool added_overflow = added_.finish(state, parts, state.step + steps);
    if (overflow != 0 || added_overflow) {
        stop(state, lost != 0 ? lost.load() : steps, steps);
    }
    observe_totals(totals);
}

template <class Record>
void FluidOf<Record>::start(State& state, const StepSettings& settings, PairTotals& totals) {
    take(state, settings, false);
    passes(state, settings, 1, true, totals);
    // Positions and velocities stay as they are given: rounding them here would make a restart differ.
    give_forces(state);
}

template <class Record>
void FluidOf<Record>::run(State& state, const StepSettings& settings, std::uint64_t steps, PairTotals& totals) {
    if (steps == 0) {
        return;
    }
    take(state, settings, true);
    passes(state, settings, steps, false, totals);
    if (scheme_.middle || scheme_.half_kinetic) {
        totals.kinetic = half_step_kinetic();
    }
    give_motion(state);
    give_forces(state);
    state.step += steps;
    for (std::uint64_t k = 0; k < steps; ++k) {
        state.time += scheme_.timestep;  // one addition a step, as everywhere, so that times agree to the bit
    }
}

template <class Record>
void FluidOf<Record>::observe_totals(PairTotals& totals) const {
    std::array<double, observed_numbers> sum{};
    for (std::size_t k = 0; k < observed_.size(); ++k) {
        sum[k % observed_numbers] += observed_[k];
    }
    totals = PairTotals();
    totals.energy = 0.5 * sum[0];
    const Vector3 length = units_.edges / fixed_range<Record>();
    const double impulse = scheme_.timestep * units_.longest / (units_.momentum * fixed_range<Record>());
    constexpr std::array<std::array<Eigen::Index, 2>, 6> axes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    std::size_t first = 1;
    for (Matrix3* tensor : {&totals.conservative, &totals.drag, &totals.noise}) {
        for (std::size_t k = 0; k < 6; ++k) {
            const auto [row, column] = axes[k];
            // A thermostat step in the middle acts for several steps at once.
            const double share = tensor == &totals.conservative ? 0.5 : 0.5 / scheme_.every;
            const double value = share * sum[first + k] * length[row] * length[column] / impulse;
            (*tensor)(row, column) = value;
            (*tensor)(column, row) = value;
        }
        first += 6;
    }
}

template class FluidOf<MixedRecord>;
template class FluidOf<DoubleRecord>;

std::unique_ptr<Fluid> make_fluid(const State& state, const PairTable& table, const StepSettings& settings,
                                  const Passes& passes, bool mixed, double cell_width) {
    if (mixed) {
        return std::make_unique<FluidOf<MixedRecord>>(state, table, settings, passes, cell_width);
    }
    return std::make_unique<FluidOf<DoubleRecord>>(state, table, settings, passes, cell_width);
}

}  // namespace dlpoly::fast
