// The fast path (see fluid.hpp).
#include "fast/fluid.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/failure.hpp"
#include "core/random.hpp"
#include "core/threads.hpp"
#include "fast/grid.hpp"
#include "fast/kinds.hpp"
#define DLPOLY_SIMD plain
#include "fast/pass.hpp"

namespace dlpoly::fast {

namespace {

// Beads a thread should have before another one pays for the waiting at the end of each step.
constexpr std::size_t beads_a_thread = 1500;

template <class T>
class AlignedArray {
  public:
    explicit AlignedArray(std::size_t count)
        : size_(count), data_(static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t{64}))) {
        std::memset(static_cast<void*>(data_), 0, count * sizeof(T));
    }
    AlignedArray(const AlignedArray&) = delete;
    AlignedArray& operator=(const AlignedArray&) = delete;
    AlignedArray(AlignedArray&&) = delete;
    AlignedArray& operator=(AlignedArray&&) = delete;
    ~AlignedArray() { ::operator delete(data_, std::align_val_t{64}); }
    T* data() noexcept { return data_; }
    const T* data() const noexcept { return data_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    void swap(AlignedArray& other) noexcept {
        std::swap(size_, other.size_);
        std::swap(data_, other.data_);
    }

  private:
    std::size_t size_;
    T* data_;
};

// Edge of a cube that holds two to three beads on average. Cells of a thin fluid are this wide: with fewer beads in a
// cell the vectors of the search stay empty, and visiting cells would cost more than the candidates they save.
double spacing(const State& state) {
    return std::cbrt(2.5 * state.box.volume() / static_cast<double>(state.particles.count()));
}

bool middle(const StepSettings& settings) { return settings.order == Order::middle; }
bool predicts(const StepSettings& settings) {
    return settings.order == Order::velocity_verlet && settings.drag && settings.prediction != 0.5;
}

template <class Record>
class FluidOf final : public Fluid {
  public:
    FluidOf(const State& state, const PairTable& table, const StepSettings& settings, const Passes& passes,
            double cell_width)
        : passes_(passes),
          kinds_(find_kinds(state.particles, most_kinds)),
          edges_(state.box.cell().diagonal()),
          grid_(make_grid(edges_, table.range(), std::max({cell_width, table.range(), spacing(state)}),
                          static_cast<int>(8 * sizeof(Fixed)))),
          beads_(static_cast<std::size_t>(state.particles.count())),
          cells_a_block_(candidates_of_block(2.0, static_cast<double>(beads_) / grid_.cells()) <= usual_candidates ? 2
                                                                                                                   : 1),
          sorted_(beads_ + padding),
          advanced_(beads_ + padding),
          shadow_x_(beads_ + padding),
          shadow_y_(beads_ + padding),
          shadow_z_(beads_ + padding),
          cell_of_(std::is_same_v<Record, MixedRecord> ? beads_ : 0),
          row_start_(static_cast<std::size_t>(grid_.cells()) + 1),
          held_(middle(settings) || predicts(settings) ? 4 * beads_ : 0),
          held_next_(predicts(settings) ? 4 * beads_ : 0),
          table_(table),
          timestep_(settings.timestep),
          has_drag_(settings.drag && table.has_drag()),
          middle_(middle(settings)),
          every_(middle_ ? settings.thermostat_every : 1),
          predicts_(predicts(settings)),
          half_kinetic_(settings.half_step_kinetic),
          prediction_(settings.prediction - 0.5) {
        const double range = momentum_range(kinds_, table, settings.thermal_energy);
        // The numbers reach further, so that leaving the range is seen.
        momentum_unit_ = std::ldexp(1.0, std::ilogb(range) + 1 - Record::momentum_bits);
        // Momenta are kept along box axes in units that are proportional to the edges, so that one constant for each
        // kind turns momentum into fixed-point distance.
        longest_ = edges_.maxCoeff();
        fill_rows(table, settings);
    }

    void set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species) override;
    void set_charges(ChargeForces& charges, ChargeTotals& totals) override;
    void start(State& state, const StepSettings& settings, PairTotals& totals) override;
    void run(State& state, const StepSettings& settings, std::uint64_t steps, PairTotals& totals) override;

  private:
    using Fixed = typename Record::Fixed;
    using Arithmetic = typename Record::Arithmetic;

    void fill_rows(const PairTable& table, const StepSettings& settings);
    void take(State& state, const StepSettings& settings, bool with_impulses);
    void give_motion(State& state);
    void give_forces(State& state);
    void passes(State& state, const StepSettings& settings, std::uint64_t steps, bool start, PairTotals& totals);
    PassArguments<Record> arguments(State& state);
    void set_word_key(PassArguments<Record>& a, const StepSettings& settings, std::uint64_t step);
    void observe_totals(PairTotals& totals) const;
    void prefix_sums();
    void sort_part(std::size_t part, bool forces_follow);
    void sort_all(std::size_t part, std::size_t parts, bool forces_follow);
    void refresh(PassArguments<Record>& a);
    void thermostat_passes(PassArguments<Record>& a, const StepSettings& settings, std::size_t part, std::size_t parts,
                           std::uint64_t step, bool observe);
    std::pair<std::int32_t, std::int32_t> share(PassArguments<Record>& a, std::size_t part, std::size_t parts);
    [[nodiscard]] bool thermostat_due(std::uint64_t step) const {
        return middle_ && has_drag_ && step % static_cast<std::uint64_t>(every_) == 0;
    }
    [[nodiscard]] Matrix3 half_step_kinetic() const;
    void order_held(std::int32_t begin, std::int32_t end);
    void order_cells(std::int32_t begin, std::int32_t end);
    [[nodiscard]] std::int32_t first_place(int part, int parts) const;
    [[nodiscard]] int thread_count() const;

    void cast_shadow(const Record& bead, std::int32_t place) {
        shadow_x_.data()[place] = static_cast<std::uint8_t>(bead.x >> grid_.shadow_shift[0]);
        shadow_y_.data()[place] = static_cast<std::uint8_t>(bead.y >> grid_.shadow_shift[1]);
        shadow_z_.data()[place] = static_cast<std::uint8_t>(bead.z >> grid_.shadow_shift[2]);
    }

    // Impulses of the last step, 3 a bead by id. They stand where the advanced records of the step before stood: once
    // those have been sorted, a last step neither reads nor writes any.
    std::int64_t* impulses() noexcept {
        static_assert(3 * sizeof(std::int64_t) <= sizeof(Record));
        return reinterpret_cast<std::int64_t*>(advanced_.data());
    }

    Pass<Record> pass_of(Variant variant) const {
        if constexpr (std::is_same_v<Record, MixedRecord>) {
            return passes_.mixed(variant);
        } else {
            return passes_.in_double(variant);
        }
    }

    [[noreturn]] void stop(State& state, std::uint64_t lost, std::uint64_t steps);
    [[noreturn]] static void report_range(std::uint64_t step, Eigen::Index bead) {
        const std::string who = bead < 0 ? "a bead" : "bead " + std::to_string(bead + 1);
        throw RunFailure(
            "step " + std::to_string(step) + ": the momentum of " + who +
            " left its range, 40 times the thermal one; the timestep is too long for the forces, or precision "
            "reference is needed, which has no such range");
    }

    [[nodiscard]] bonded::Request bonded_request(bool observe, int energy_exponent) const;
    void observe_bonded(const State& state);
    void make_room(std::uint32_t end);
    void place_bonded(const Record& bead);
    bool add_charges(const State& state, std::uint64_t step, bool observe);
    bool add_bonded_terms(const State& state, std::size_t part, bool observe);
    [[nodiscard]] bool bonded_overflow() const;
    double axis_unit(Eigen::Index axis) const { return momentum_unit_ * edges_[axis] / longest_; }

    const Passes& passes_;
    Kinds kinds_;
    Vector3 edges_;
    Grid grid_;
    std::size_t beads_;
    std::int32_t cells_a_block_;
    AlignedArray<Record> sorted_;
    AlignedArray<Record> advanced_;
    AlignedArray<std::uint8_t> shadow_x_;
    AlignedArray<std::uint8_t> shadow_y_;
    AlignedArray<std::uint8_t> shadow_z_;
    AlignedArray<std::int32_t> cell_of_;
    AlignedArray<std::int32_t> row_start_;
    AlignedArray<Fixed> held_;       // in the order of sorted_, see PassArguments
    AlignedArray<Fixed> held_next_;  // in the order of advanced_
    std::array<PairRow<Arithmetic>, most_kinds> rows_{};
    // Of thermostat steps in the middle of the drift, which take noise and drag in passes of their own.
    std::array<PairRow<Arithmetic>, most_kinds> noise_rows_{};
    std::array<PairRow<Arithmetic>, most_kinds> drag_rows_{};
    std::array<PairRow<Arithmetic>, most_kinds> motion_rows_{};  // both at once
    std::array<Arithmetic, most_kinds> inverse_mass_{};
    std::array<Arithmetic, most_kinds> drift_{};
    std::array<Arithmetic, most_kinds> half_drift_{};
    std::vector<std::vector<std::int32_t>> histograms_;
    std::vector<std::int32_t> part_;  // beads part_[t] … part_[t + 1] of `advanced_` belong to thread t
    std::vector<double> observed_;    // observed_numbers a row of cells
    const PairTable& table_;
    BondedForces* bonded_ = nullptr;
    BondedTotals* bonded_totals_ = nullptr;
    std::vector<std::int32_t> species_;
    std::vector<double> bonded_positions_;       // 3 a bead, by id
    std::vector<std::int64_t> bonded_impulses_;  // 3 a bead, by id, zeros between steps
    std::vector<bonded::Worker> bonded_workers_;
    ChargeForces* charges_ = nullptr;
    ChargeTotals* charge_totals_ = nullptr;
    std::uint32_t placed_end_ = 0;  // beads below it have a place in bonded_positions_; 0: no need of any
    std::atomic<bool> charges_stop_{false};
    std::exception_ptr charge_failure_;
    double momentum_unit_ = 0.0;  // along the longest edge
    double longest_ = 0.0;
    double timestep_;
    bool has_drag_;
    bool middle_;  // drag and noise act in the middle of the drift, every so many steps
    int every_;
    bool predicts_;      // the drag sees velocities ahead of the half step's: Groot and Warren's λ is not ½
    bool half_kinetic_;  // the kinetic energy is that of the half-step velocities
    double prediction_;  // λ − ½
};

// Constants of every pair of kinds; see arguments.hpp for their scale.
template <class Record>
void FluidOf<Record>::fill_rows(const PairTable& table, const StepSettings& settings) {
    const double fixed_range = std::ldexp(1.0, static_cast<int>(8 * sizeof(Fixed)));
    const double impulse = settings.timestep * longest_ / (momentum_unit_ * fixed_range);
    const bool one_kind = kinds_.list.size() == 1;
    const double velocity = momentum_unit_ * fixed_range / longest_ / (one_kind ? kinds_.list.front().mass : 1.0);
    const double noise = word_to_noise / std::sqrt(settings.timestep);
    for (std::size_t i = 0; i < kinds_.list.size(); ++i) {
        const Kinds::Kind& a = kinds_.list[i];
        inverse_mass_[i] = static_cast<Arithmetic>(a.frozen ? 0.0 : 1.0 / a.mass);
        drift_[i] = static_cast<Arithmetic>(a.frozen ? 0.0
                                                     : momentum_unit_ * settings.timestep / (a.mass * longest_) *
                                                           std::ldexp(1.0, Record::position_bits));
        for (std::size_t j = 0; j < kinds_.list.size(); ++j) {
            const Kinds::Kind& b = kinds_.list[j];
            const std::uint32_t term = table.term(a.species, b.species);
            const PairTable::SoftLaw law = table.soft_law(term);
            const PairDrag& drag = table.drags()[term];
            const bool dragged = has_drag_ && drag.drag > 0.0;
            const double cutoff = law.cutoff > 0.0 ? law.cutoff : dragged ? drag.cutoff : table.range();
            rows_[i].inverse_cutoff[j] = static_cast<Arithmetic>(1.0 / cutoff);
            if (a.frozen && b.frozen) {
                continue;
            }
            rows_[i].repulsion[j] = static_cast<Arithmetic>(impulse * law.repulsion);
            rows_[i].energy[j] = static_cast<Arithmetic>(0.5 * law.repulsion * law.cutoff);
            rows_[i].drag[j] = static_cast<Arithmetic>(dragged ? every_ * impulse * drag.drag * velocity : 0.0);
            rows_[i].noise[j] =
                static_cast<Arithmetic>(dragged ? std::sqrt(every_) * impulse * drag.noise * noise : 0.0);
        }
        half_drift_[i] = static_cast<Arithmetic>(0.5) * drift_[i];
    }
    if (middle_) {
        for (std::size_t i = 0; i < kinds_.list.size(); ++i) {
            motion_rows_[i] = rows_[i];
            for (std::size_t j = 0; j < kinds_.list.size(); ++j) {
                motion_rows_[i].repulsion[j] = motion_rows_[i].energy[j] = 0;
                rows_[i].drag[j] = rows_[i].noise[j] = 0;
            }
            noise_rows_[i] = drag_rows_[i] = motion_rows_[i];
            for (std::size_t j = 0; j < kinds_.list.size(); ++j) {
                noise_rows_[i].drag[j] = drag_rows_[i].noise[j] = 0;
            }
        }
    }
}

// Reads the state into records. With impulses, the state is at the end of an earlier chunk, and the beads are advanced
// to the first positions at which new impulses are needed.
template <class Record>
void FluidOf<Record>::take(State& state, const StepSettings& settings, bool with_impulses) {
    Particles& particles = state.particles;
    const double timestep = settings.timestep;
    const double largest = std::ldexp(1.0, Record::momentum_bits);
    histograms_.assign(1, std::vector<std::int32_t>(static_cast<std::size_t>(grid_.cells()), 0));
    part_ = {0, static_cast<std::int32_t>(beads_)};
    PassArguments<Record> step = arguments(state);
    set_word_key(step, settings, with_impulses ? state.step + 1 : state.step);
    step.drift = thermostat_due(state.step + 1) ? half_drift_.data() : drift_.data();
    const auto beads = static_cast<Eigen::Index>(beads_);
    Record* records = advanced_.data();
    for (Eigen::Index i = 0; i < beads; ++i) {
        const auto id = static_cast<std::size_t>(i);
        const std::uint8_t kind = kinds_.of_bead[id];
        Record& bead = records[i];
        bead = Record{};
        bead.tag = (static_cast<std::uint32_t>(kind) << kind_shift) | static_cast<std::uint32_t>(i);
        std::array<Fixed*, 3> position{&bead.x, &bead.y, &bead.z};
        std::array<Fixed*, 3> momentum{&bead.px, &bead.py, &bead.pz};
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            const double scale = std::ldexp(1.0, Record::position_bits) / edges_[axis];
            constexpr int unused_bits = static_cast<int>(8 * sizeof(Fixed)) - Record::position_bits;
            const std::int64_t rounded = std::llrint(particles.position(i, axis) * scale);
            // The upper face is the lower one of the next image.
            if (rounded == std::int64_t{1} << (Record::position_bits - 1)) {
                particles.position(i, axis) -= edges_[axis];
                ++particles.image(i, axis);
            }
            *position[k] = static_cast<Fixed>(static_cast<std::uint64_t>(rounded) << unused_bits);
            if (!kinds_.list[kind].frozen) {
                const double unit = axis_unit(axis);
                // Velocities of a state are those of whole steps: half an impulse ahead of the leapfrog's momentum.
                const double impulse = with_impulses ? std::rint(particles.force(i, axis) * timestep / unit) : 0.0;
                const double exact = particles.velocity(i, axis) * particles.mass[id] / unit - 0.5 * impulse;
                if (!(std::abs(exact) < largest)) {
                    report_range(state.step, i);
                }
                *momentum[k] = static_cast<Fixed>(std::llrint(exact));
            }
        }
        if (with_impulses) {
            std::array<Fixed, 4> impulse{};
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                impulse[static_cast<std::size_t>(axis)] =
                    static_cast<Fixed>(std::llrint(particles.force(i, axis) * timestep / axis_unit(axis)));
            }
            const Record before = bead;
            plain::advance_bead(step, before, impulse.data(), bead);
        }
        if (predicts_) {
            Fixed* held = held_next_.data() + 4 * id;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<std::size_t>(axis);
                const auto impulse =
                    static_cast<Fixed>(std::llrint(particles.force(i, axis) * timestep / axis_unit(axis)));
                held[k] = with_impulses && !kinds_.list[kind].frozen
                              ? static_cast<Fixed>(plain::nearest(static_cast<Arithmetic>(impulse) * step.prediction))
                              : Fixed{0};
                *momentum[k] += held[k];
            }
        }
        bead.word = bead_word(static_cast<std::uint32_t>(i), step.word_key);
        const std::int32_t cell = plain::cell_of(step, bead);
        plain::keep_cell(step, static_cast<std::int32_t>(i), cell);
        ++histograms_.front()[static_cast<std::size_t>(cell)];
    }
    if (step.overflow != 0) {
        report_range(state.step, -1);
    }
}

// Writes positions and velocities of the whole step back.
template <class Record>
void FluidOf<Record>::give_motion(State& state) {
    Particles& particles = state.particles;
    const Record* records = sorted_.data();
    for (std::size_t place = 0; place < beads_; ++place) {
        const Record& bead = records[place];
        const std::size_t id = bead.tag & id_mask;
        const auto i = static_cast<Eigen::Index>(id);
        if (kinds_.list[bead.tag >> kind_shift].frozen) {
            continue;
        }
        const std::array<Fixed, 3> position{bead.x, bead.y, bead.z};
        const std::array<Fixed, 3> momentum{bead.px, bead.py, bead.pz};
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            constexpr int unused_bits = static_cast<int>(8 * sizeof(Fixed)) - Record::position_bits;
            particles.position(i, axis) = static_cast<double>(position[k] >> unused_bits) *
                                          (edges_[axis] * std::ldexp(1.0, -Record::position_bits));
            const double half_step =
                static_cast<double>(predicts_ ? momentum[k] - held_.data()[4 * place + k] : momentum[k]);
            const double whole = half_step + 0.5 * static_cast<double>(impulses()[3 * id + k]);
            particles.velocity(i, axis) = whole * axis_unit(axis) / particles.mass[id];
        }
    }
}

template <class Record>
void FluidOf<Record>::give_forces(State& state) {
    Particles& particles = state.particles;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        const auto id = static_cast<std::size_t>(i);
        const bool frozen = particles.frozen[id] != 0;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto impulse = static_cast<double>(impulses()[3 * id + static_cast<std::size_t>(axis)]);
            particles.force(i, axis) = frozen ? 0.0 : impulse * axis_unit(axis) / timestep_;
        }
    }
}

template <class Record>
PassArguments<Record> FluidOf<Record>::arguments(State& state) {
    PassArguments<Record> a{};
    refresh(a);
    a.shadow_x = shadow_x_.data();
    a.shadow_y = shadow_y_.data();
    a.shadow_z = shadow_z_.data();
    a.row_start = row_start_.data();
    a.row_rank = grid_.row_rank.data();
    a.row_at = grid_.row_at.data();
    a.cells_x = grid_.counts[0];
    a.rows_y = grid_.counts[1];
    a.rows_z = grid_.counts[2];
    a.cells_a_block = cells_a_block_;
    a.distance_x = grid_.distance[0].data();
    a.distance_y = grid_.distance[1].data();
    a.distance_z = grid_.distance[2].data();
    a.threshold = grid_.threshold;
    const Vector3 length = edges_ * std::ldexp(1.0, -static_cast<int>(8 * sizeof(Fixed)));
    a.metric_x = static_cast<Arithmetic>(length[0] * length[0]);
    a.metric_y = static_cast<Arithmetic>(length[1] * length[1]);
    a.metric_z = static_cast<Arithmetic>(length[2] * length[2]);
    a.rows = rows_.data();
    a.inverse_mass = inverse_mass_.data();
    a.drift = drift_.data();
    a.images = state.particles.image.data();
    a.cell_of = cell_of_.data();
    a.stage = Stage::advance;
    if (predicts_) {
        a.stage = Stage::predict;
    }
    a.held = held_.data();
    a.held_next = held_next_.data();
    a.prediction = static_cast<Arithmetic>(prediction_);
    return a;
}

// Where the records are; they change places in thermostat steps.
template <class Record>
void FluidOf<Record>::refresh(PassArguments<Record>& a) {
    a.sorted = sorted_.data();
    a.advanced = advanced_.data();
    a.impulses = impulses();
}

// The random words made from now on belong to this step.
template <class Record>
void FluidOf<Record>::set_word_key(PassArguments<Record>& a, const StepSettings& settings, std::uint64_t step) {
    const auto key = bead_word_key(settings.seed, step);
    std::copy(key.begin(), key.end(), a.word_key);
}

template <class Record>
int FluidOf<Record>::thread_count() const {
    const auto useful = static_cast<int>(std::max<std::size_t>(1, beads_ / beads_a_thread));
    return std::min({thread_limit(), useful, grid_.rows()});
}

// Starts of all cells for every thread's beads: stable in the threads' order, which is that of the beads.
template <class Record>
void FluidOf<Record>::prefix_sums() {
    std::int32_t* start = row_start_.data();
    std::int32_t sum = 0;
    for (std::size_t cell = 0; cell < static_cast<std::size_t>(grid_.cells()); ++cell) {
        start[cell] = sum;
        for (std::vector<std::int32_t>& histogram : histograms_) {
            const std::int32_t beads = histogram[cell];
            histogram[cell] = sum;
            sum += beads;
        }
    }
    start[grid_.cells()] = sum;
}

template <class Record>
void FluidOf<Record>::sort_part(std::size_t part, bool forces_follow) {
    std::int32_t* next = histograms_[part].data();
    const Record* from = advanced_.data();
    Record* to = sorted_.data();
    for (std::int32_t i = part_[part]; i < part_[part + 1]; ++i) {
        const std::int32_t place = next[plain::kept_cell(cell_of_.data(), from, i)]++;
        to[place] = from[i];
        if (predicts_) {
            std::copy_n(held_next_.data() + 4 * static_cast<std::size_t>(i), 4,
                        held_.data() + 4 * static_cast<std::size_t>(place));
        }
        cast_shadow(from[i], place);
        if (placed_end_ > 0 && forces_follow) {
            place_bonded(from[i]);
        }
    }
}

// Puts what is held for the beads of one cell into the order of their ids.
template <class Record>
void FluidOf<Record>::order_held(std::int32_t begin, std::int32_t end) {
    std::vector<std::pair<std::uint32_t, std::array<Fixed, 4>>> beads;
    for (std::int32_t i = begin; i < end; ++i) {
        std::array<Fixed, 4> held{};
        std::copy_n(held_.data() + 4 * static_cast<std::size_t>(i), 4, held.begin());
        beads.emplace_back(sorted_.data()[i].tag & id_mask, held);
    }
    std::sort(beads.begin(), beads.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::int32_t i = begin; i < end; ++i) {
        const std::array<Fixed, 4>& held = beads[static_cast<std::size_t>(i - begin)].second;
        std::copy_n(held.begin(), 4, held_.data() + 4 * static_cast<std::size_t>(i));
    }
}

// Puts the beads of each cell into the order of their ids. Forces do not depend on the order, but the sums of an
// observed step are floating-point ones: with one order they are the same to the bit however a run was cut into chunks.
template <class Record>
void FluidOf<Record>::order_cells(std::int32_t begin, std::int32_t end) {
    const std::int32_t* start = row_start_.data();
    for (std::int32_t cell = begin * grid_.counts[0]; cell < end * grid_.counts[0]; ++cell) {
        Record* first = sorted_.data() + start[cell];
        Record* last = sorted_.data() + start[cell + 1];
        if (predicts_) {
            order_held(start[cell], start[cell + 1]);
        }
        std::sort(first, last, [](const Record& a, const Record& b) { return (a.tag & id_mask) < (b.tag & id_mask); });
        for (std::int32_t i = start[cell]; i < start[cell + 1]; ++i) {
            cast_shadow(sorted_.data()[i], i);
        }
    }
}

// The place at which a part's rows begin when beads are shared out evenly.
template <class Record>
std::int32_t FluidOf<Record>::first_place(int part, int parts) const {
    if (part == parts) {
        return grid_.rows();
    }
    const auto target = static_cast<std::int32_t>(static_cast<std::int64_t>(beads_) * part / parts);
    std::int32_t low = 0;
    std::int32_t high = grid_.rows();
    while (low < high) {
        const std::int32_t middle = (low + high) / 2;
        if (row_start_.data()[static_cast<std::int64_t>(middle) * grid_.counts[0]] < target) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

// Brings the advanced beads into the order of the cells. Called by all threads together.
template <class Record>
void FluidOf<Record>::sort_all(std::size_t part, std::size_t parts, bool forces_follow) {
#ifdef _OPENMP
#pragma omp single
#endif
    prefix_sums();
    const auto written = histograms_.size();
    for (std::size_t source = part; source < written; source += parts) {
        sort_part(source, forces_follow);
    }
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    {
        histograms_.resize(parts);
        part_.assign(parts + 1, 0);
    }
}

// The rows of cells that a thread handles; also where it writes what it advances.
template <class Record>
std::pair<std::int32_t, std::int32_t> FluidOf<Record>::share(PassArguments<Record>& a, std::size_t part,
                                                             std::size_t parts) {
    std::vector<std::int32_t>& histogram = histograms_[part];
    histogram.assign(static_cast<std::size_t>(grid_.cells()), 0);
    a.histogram = histogram.data();
    const std::int32_t begin = first_place(static_cast<int>(part), static_cast<int>(parts));
    const std::int32_t end = first_place(static_cast<int>(part) + 1, static_cast<int>(parts));
    part_[part + 1] = row_start_.data()[static_cast<std::int64_t>(end) * grid_.counts[0]];
    return {begin, end};
}

// Drag and noise at the positions in the middle of a drift, and its second half; see integrate/middle.hpp for the
// formulas. Called by all threads together.
template <class Record>
void FluidOf<Record>::thermostat_passes(PassArguments<Record>& a, const StepSettings& settings, std::size_t part,
                                        std::size_t parts, std::uint64_t step, bool observe) {
    sort_all(part, parts, false);
    const auto [begin, end] = share(a, part, parts);
    if (observe) {
        order_cells(begin, end);
#ifdef _OPENMP
#pragma omp barrier
#endif
    }
    std::int64_t* const bonded = a.bonded;
    const auto one_kind = kinds_.list.size() == 1;
    const Pass<Record> pass = pass_of({one_kind, true, false, false});
    const Pass<Record> watched = pass_of({one_kind, true, true, false});
    a.bonded = nullptr;
    a.drift = half_drift_.data();
    set_word_key(a, settings, step);
    const auto exchange = [&] {
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
        sorted_.swap(advanced_);
        refresh(a);
    };
    if (settings.passes == 1) {
        a.rows = motion_rows_.data();
        a.stage = Stage::advance;
        (observe ? watched : pass)(a, begin, end);
    } else {
        a.rows = noise_rows_.data();
        a.stage = settings.passes == 2 ? Stage::noise_alone : Stage::noise;
        (observe ? watched : pass)(a, begin, end);
        exchange();
        a.rows = drag_rows_.data();
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
    a.rows = rows_.data();
    a.bonded = bonded;
}

template <class Record>
void FluidOf<Record>::passes(State& state, const StepSettings& settings, std::uint64_t steps, bool start,
                             PairTotals& totals) {
    const bool one_kind = kinds_.list.size() == 1;
    const bool drag = has_drag_ && !middle_;
    const Pass<Record> inner = pass_of({one_kind, drag, false, false});
    const Pass<Record> last = pass_of({one_kind, drag, true, true});
    observed_.assign(static_cast<std::size_t>(grid_.rows()) * observed_numbers, 0.0);
    std::uint64_t overflow = 0;
    std::atomic<std::uint64_t> lost{0};  // the step of this call in which a momentum left its range
    const int asked = thread_count();
    std::size_t parts = 1;
    bonded_workers_.assign(static_cast<std::size_t>(asked) + 1,
                           bonded::Worker(bonded_request(false, 0), bonded_impulses_.data()));
#ifdef _OPENMP
#pragma omp parallel num_threads(asked)
#endif
    {
        const auto part = static_cast<std::size_t>(thread_number());
#ifdef _OPENMP
#pragma omp single
        parts = static_cast<std::size_t>(omp_get_num_threads());
#endif
        if (bonded_ != nullptr) {
#ifdef _OPENMP
#pragma omp single
#endif
            bonded_->prepare(parts);
        }
        PassArguments<Record> a = arguments(state);
        a.observed = observed_.data();
        a.bonded = placed_end_ > 0 ? bonded_impulses_.data() : nullptr;
        a.bonded_end = placed_end_;
        AlignedArray<std::uint8_t> workspace(workspace_bytes);
        a.workspace = workspace.data();
        for (std::uint64_t k = 1; k <= steps; ++k) {
            if (!start && thermostat_due(state.step + k)) {
                thermostat_passes(a, settings, part, parts, state.step + k, k == steps);
            }
            sort_all(part, parts, true);
            if (bonded_ != nullptr && !add_bonded_terms(state, part, k == steps)) {
                break;
            }
            if (charges_ != nullptr && !add_charges(state, state.step + k, k == steps)) {
                break;
            }
            const auto [begin, end] = share(a, part, parts);
            if (k == steps) {
                order_cells(begin, end);
#ifdef _OPENMP
#pragma omp barrier
#endif
            }
            a.drift = thermostat_due(state.step + k + 1) ? half_drift_.data() : drift_.data();
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
    if (bonded_ != nullptr) {
        BondedForces::report(bonded_workers_, bonded::MinimumImage(state.box), state.step + steps);
        observe_bonded(state);
    }
    if (charge_failure_) {
        std::fill(bonded_impulses_.begin(), bonded_impulses_.end(), 0);
        std::rethrow_exception(std::exchange(charge_failure_, nullptr));
    }
    if (overflow != 0 || bonded_overflow() || charges_stop_) {
        stop(state, lost != 0 ? lost.load() : steps, steps);
    }
    observe_totals(totals);
}

// Leaves the beads where they were after the step that failed, and names one whose momentum is out of range.
template <class Record>
void FluidOf<Record>::stop(State& state, std::uint64_t lost, std::uint64_t steps) {
    Eigen::Index first = -1;
    if (lost < steps) {  // the beads were advanced
        Particles& particles = state.particles;
        for (std::size_t k = 0; k < beads_; ++k) {
            const Record& bead = advanced_.data()[k];
            const auto id = static_cast<Eigen::Index>(bead.tag & id_mask);
            const Kinds::Kind& kind = kinds_.list[bead.tag >> kind_shift];
            const std::array<Fixed, 3> position{bead.x, bead.y, bead.z};
            const std::array<Fixed, 3> momentum{bead.px, bead.py, bead.pz};
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const auto n = static_cast<std::size_t>(axis);
                constexpr int unused_bits = static_cast<int>(8 * sizeof(Fixed)) - Record::position_bits;
                if (kind.frozen) {
                    continue;
                }
                particles.position(id, axis) = static_cast<double>(position[n] >> unused_bits) *
                                               (edges_[axis] * std::ldexp(1.0, -Record::position_bits));
                particles.velocity(id, axis) = static_cast<double>(momentum[n]) * axis_unit(axis) / kind.mass;
                const bool beyond =
                    std::abs(static_cast<double>(momentum[n])) >= std::ldexp(1.0, Record::momentum_bits);
                first = beyond && (first < 0 || id < first) ? id : first;
            }
        }
    }
    state.step += lost;
    for (std::uint64_t k = 0; k < lost; ++k) {
        state.time += timestep_;
    }
    report_range(state.step, first);
}

// Σ m v_a v_b of the momenta between two force evaluations; with drag and noise in the middle, of those after them.
template <class Record>
Matrix3 FluidOf<Record>::half_step_kinetic() const {
    Matrix3 tensor = Matrix3::Zero();
    for (std::size_t place = 0; place < beads_; ++place) {
        const Record& bead = sorted_.data()[place];
        const Kinds::Kind& kind = kinds_.list[bead.tag >> kind_shift];
        if (kind.frozen) {
            continue;
        }
        const std::array<Fixed, 3> ahead{bead.px, bead.py, bead.pz};
        Vector3 momentum;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            const Fixed held = predicts_ ? held_.data()[4 * place + k] : Fixed{0};
            momentum[axis] = static_cast<double>(ahead[k] - held) * axis_unit(axis);
        }
        tensor += momentum * momentum.transpose() / kind.mass;
    }
    return tensor;
}

template <class Record>
void FluidOf<Record>::set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species) {
    bonded_ = &terms;
    bonded_totals_ = &totals;
    species_ = std::move(species);
    make_room(terms.bead_end());
}

template <class Record>
void FluidOf<Record>::set_charges(ChargeForces& charges, ChargeTotals& totals) {
    charges_ = &charges;
    charge_totals_ = &totals;
    make_room(charges.charges().beads.back() + 1);
}

template <class Record>
void FluidOf<Record>::make_room(std::uint32_t end) {
    placed_end_ = std::max(placed_end_, end);
    bonded_positions_.assign(3 * std::size_t{placed_end_}, 0.0);
    bonded_impulses_.assign(3 * std::size_t{placed_end_}, 0);
}

// Called by all threads together; false in all of them when the forces cannot be computed. One thread computes them:
// the charges are few among the beads.
template <class Record>
bool FluidOf<Record>::add_charges(const State& state, std::uint64_t step, bool observe) {
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    try {
        const std::vector<std::uint32_t>& beads = charges_->charges().beads;
        Array3N positions(static_cast<Eigen::Index>(beads.size()), 3);
        for (std::size_t i = 0; i < beads.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                positions(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) =
                    bonded_positions_[3 * std::size_t{beads[i]} + axis];
            }
        }
        const std::vector<std::int64_t>* impulses = charges_->compute(
            state.box, positions, bonded_request(false, 0).scale, step, observe ? charge_totals_ : nullptr);
        charges_stop_ = impulses == nullptr;
        for (std::size_t i = 0; impulses != nullptr && i < beads.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                bonded_impulses_[3 * std::size_t{beads[i]} + axis] += (*impulses)[3 * i + axis];
            }
        }
    } catch (...) {
        charge_failure_ = std::current_exception();
        charges_stop_ = true;
    }
    return !charges_stop_;
}

// Forces of bonded terms are rounded straight to impulses, so that they conserve momentum to the bit as pairs do.
template <class Record>
bonded::Request FluidOf<Record>::bonded_request(bool observe, int energy_exponent) const {
    bonded::Request request;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        request.scale[axis] = timestep_ / axis_unit(axis);
    }
    request.energy_scale = std::ldexp(1.0, energy_exponent);
    request.observe = observe;
    return request;
}

template <class Record>
void FluidOf<Record>::place_bonded(const Record& bead) {
    const std::size_t id = bead.tag & id_mask;
    if (id >= placed_end_) {
        return;
    }
    constexpr int unused_bits = static_cast<int>(8 * sizeof(Fixed)) - Record::position_bits;
    const std::array<Fixed, 3> position{bead.x, bead.y, bead.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double edge = edges_[static_cast<Eigen::Index>(axis)];
        bonded_positions_[3 * id + axis] =
            static_cast<double>(position[axis] >> unused_bits) * (edge * std::ldexp(1.0, -Record::position_bits));
    }
}

// Called by all threads together; false in all of them when a term cannot be computed.
template <class Record>
bool FluidOf<Record>::add_bonded_terms(const State& state, std::size_t part, bool observe) {
    const bonded::MinimumImage image(state.box);
    const auto walk = [&](std::size_t p) {
        bonded_workers_[p] =
            bonded::Worker(bonded_request(observe, bonded_->energy_exponent()), bonded_impulses_.data());
        bonded_->part(p, image, bonded_positions_.data(), species_, table_, bonded_workers_[p]);
    };
    walk(part);
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    walk(histograms_.size());  // one part a thread, and after them the terms that cross their borders
    for (const bonded::Worker& worker : bonded_workers_) {
        if (worker.failure().law != nullptr) {
            return false;
        }
    }
    return true;
}

// Totals of the observed step. Energies beyond their grid are rare (a random start): they are then added up once more
// on a coarser one, as on the general path.
template <class Record>
void FluidOf<Record>::observe_bonded(const State& state) {
    const bonded::MinimumImage image(state.box);
    int exponent = bonded_->energy_exponent();
    std::vector<std::int64_t> unused;
    for (;;) {
        double largest = 0.0;
        for (const bonded::Worker& worker : bonded_workers_) {
            largest = std::max(largest, worker.largest_energy());
        }
        if (largest < 1.0) {
            *bonded_totals_ = BondedForces::total(bonded_workers_, exponent);
            return;
        }
        exponent -= std::ilogb(largest) + 1;
        unused.assign(bonded_impulses_.size(), 0);
        for (std::size_t p = 0; p <= histograms_.size(); ++p) {
            bonded_workers_[p] = bonded::Worker(bonded_request(true, exponent), unused.data());
            bonded_->part(p, image, bonded_positions_.data(), species_, table_, bonded_workers_[p]);
        }
    }
}

template <class Record>
bool FluidOf<Record>::bonded_overflow() const {
    return std::any_of(bonded_workers_.begin(), bonded_workers_.end(),
                       [](const bonded::Worker& worker) { return worker.largest() >= 1.0; });
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
    if (middle_ || half_kinetic_) {
        totals.kinetic = half_step_kinetic();
    }
    give_motion(state);
    give_forces(state);
    state.step += steps;
    for (std::uint64_t k = 0; k < steps; ++k) {
        state.time += settings.timestep;  // one addition a step, as everywhere, so that times agree to the bit
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
    const double fixed_range = std::ldexp(1.0, static_cast<int>(8 * sizeof(Fixed)));
    const Vector3 length = edges_ / fixed_range;
    const double impulse = timestep_ * longest_ / (momentum_unit_ * fixed_range);
    constexpr std::array<std::array<Eigen::Index, 2>, 6> axes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    std::size_t first = 1;
    for (Matrix3* tensor : {&totals.conservative, &totals.drag, &totals.noise}) {
        for (std::size_t k = 0; k < 6; ++k) {
            const auto [row, column] = axes[k];
            // A thermostat step in the middle acts for several steps at once.
            const double share = tensor == &totals.conservative ? 0.5 : 0.5 / every_;
            const double value = share * sum[first + k] * length[row] * length[column] / impulse;
            (*tensor)(row, column) = value;
            (*tensor)(column, row) = value;
        }
        first += 6;
    }
}

}  // namespace

std::unique_ptr<Fluid> make_fluid(const State& state, const PairTable& table, const StepSettings& settings,
                                  const Passes& passes, bool mixed, double cell_width) {
    if (mixed) {
        return std::make_unique<FluidOf<MixedRecord>>(state, table, settings, passes, cell_width);
    }
    return std::make_unique<FluidOf<DoubleRecord>>(state, table, settings, passes, cell_width);
}

const Passes& chosen_passes() {
    const char* wish = std::getenv("PYDLPOLY_SIMD");
    const std::string name = wish == nullptr ? "" : wish;
    const Passes* best = avx512_passes() != nullptr ? avx512_passes()
                         : avx2_passes() != nullptr ? avx2_passes()
                                                    : &plain_passes();
    if (name.empty()) {
        return *best;
    }
    const Passes* chosen = name == "plain"    ? &plain_passes()
                           : name == "avx2"   ? avx2_passes()
                           : name == "avx512" ? avx512_passes()
                                              : nullptr;
    if (chosen == nullptr) {
        throw std::invalid_argument("PYDLPOLY_SIMD is '" + name +
                                    "'; expected plain, avx2 or avx512, as far as this processor has them");
    }
    return *chosen;
}

}  // namespace dlpoly::fast
