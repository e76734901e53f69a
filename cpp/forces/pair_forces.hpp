// The pair loop: pair list, pair laws, drag and noise, and their exact sums on beads and over the system.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/box.hpp"
#include "core/exact_sum.hpp"
#include "core/particles.hpp"
#include "forces/exclusions.hpp"
#include "forces/pair_list.hpp"
#include "forces/pair_modifier.hpp"
#include "forces/pair_phases.hpp"
#include "forces/pair_table.hpp"
#include "forces/pair_worker.hpp"
#include "forces/skin_tuner.hpp"
#include "forces/weight_loops.hpp"

namespace dlpoly {

// Sums over all pairs. Virial tensors hold Σ F_a (r_i − r_j)_b, so that the stress they add is this over the volume.
struct PairTotals {
    double energy = 0.0;
    Matrix3 conservative = Matrix3::Zero();
    Matrix3 drag = Matrix3::Zero();
    Matrix3 noise = Matrix3::Zero();
    // Σ m v_a v_b in the middle of the step, from integrators that thermalise there: that is where velocities have the
    // Maxwell distribution, and those of the whole step are too slow by O(Δt²). Absent: take the present velocities.
    std::optional<Matrix3> kinetic;
};

class PairForces {
  public:
    // thermal_energy and timestep only choose the grid of the exact sums.
    PairForces(PairTable table, double thermal_energy, double timestep);

    // Cells at least this wide instead of one range wide; 0 = one range. Changes speed, never results.
    void set_cell_width(double width) noexcept { cell_width_ = width; }

    // Pairs that are left out, with their drag and noise.
    void set_exclusions(Exclusions exclusions) {
        exclusions_ = std::move(exclusions);
        list_.forget();
    }
    [[nodiscard]] bool has_exclusions() const noexcept { return !exclusions_.empty(); }
    [[nodiscard]] const Exclusions& exclusions() const noexcept { return exclusions_; }

    // Adds a part that needs more than distances; they act in the order they were added.
    void add_modifier(std::shared_ptr<PairModifier> modifier);
    [[nodiscard]] const std::vector<std::shared_ptr<PairModifier>>& modifiers() const noexcept { return modifiers_; }

    // Writes the pair force on every bead to particles.force (frozen beads: zero). Drag uses `velocity`.
    // Throws RunFailure when a pair's force is not finite, naming both beads.
    void compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                 PairTotals& totals);

    // Σ ∂²U/∂x² of all pairs over the coordinates of the mobile beads; not a number when it is beyond all bounds.
    [[nodiscard]] double curvature(const Box& box, const Particles& particles);

    // Shows the visitor every pair within its reach.
    void visit(const Box& box, const Particles& particles, PairVisitor& visitor);

    // Shows drag and noise of every pair as compute() makes them of this request and these velocities.
    void visit_motion(const Box& box, const Particles& particles, const Array3N& velocity, const ForceRequest& request,
                      MotionVisitor& visitor);

    // Shows them also while compute() finds them; the visitor must live as long as this, nullptr ends it.
    void watch_motion(MotionVisitor* watcher) noexcept { watcher_ = watcher; }

    // The same for the pair list as it is, within PairModifier::prepare.
    void show(PairVisitor& visitor, int threads);
    // Ids in the order of the batches' indices.
    [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return list_.order(); }

    [[nodiscard]] const PairTable& table() const noexcept { return table_; }
    // The grid that sums of energies begin with.
    [[nodiscard]] int energy_exponent() const noexcept { return base_energy_exponent_; }
    [[nodiscard]] const LinkCells& cells() const noexcept { return list_.cells(); }

  private:
    struct Largest {
        double force = 0.0;
        double energy = 0.0;
    };

    void update_list(const Box& box, const Particles& particles, int threads);
    // Returns the seconds it took; the skin of the list is chosen by them, too.
    double prepare_modifiers(const Box& box, const Particles& particles, int threads, bool conservative);
    void gather_motion(const Array3N& velocity, const ForceRequest& request, int threads);
    void spread_forces(Particles& particles, double unit, int threads) const;
    void collect_totals(int energy_exponent, PairTotals& totals) const;
    [[nodiscard]] Largest visit_pairs(const PairWalk& walk);
    void visit_row(const ListRow& row, const PairWalk& walk, PairWorker& worker);
    void add_curvature(const PairWalk& walk, PairWorker& worker) const;
    void finish_batch(const PairWalk& walk, PairWorker& worker);
    void find_motion(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const;
    // Drag and noise by formula: pair_motion.cpp.
    void evaluate_motion(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const;
    void change_weights(const PairBatch& batch, BatchResult& result, double cutoff, double exponent) const;
    void add_drag_of_shear(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const;
    void find_worst(const PairWalk& walk, PairWorker& worker) const;
    [[noreturn]] void report_overflow(const PairWorker& worst, std::uint64_t step) const;

    PairTable table_;
    Exclusions exclusions_;
    const Phases* phases_;
    const WeightLoops* weights_;
    PairList list_;
    SkinTuner tuner_;
    double cell_width_ = 0.0;
    int base_exponent_;
    int base_energy_exponent_;
    bool any_law_or_noise_ = false;

    std::vector<std::shared_ptr<PairModifier>> modifiers_;
    MotionVisitor* watcher_ = nullptr;
    std::vector<MotionRecord> motion_;  // in sorted order
    std::vector<GridForce> sums_;       // in sorted order
    std::vector<std::unique_ptr<PairWorker>> workers_;
};

}  // namespace dlpoly
