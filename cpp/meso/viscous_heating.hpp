// Heat from the drag and noise that are forces (mdvv): what they take from the kinetic energy of a pair goes in halves
// to the internal energies of its beads.
//
// Conserving: a force f acts in two half kicks, one before and one after the velocities v of the whole step, and does
// the work Δt f·v in both. It depends on v and is known at the end of the step, so that beads are then charged for
// both halves; what the second will do is kept in State::heat_ahead, and the kinetic, potential and internal energy and
// heat_ahead have a sum that drag and noise leave as it is, to round-off.
//
// As LAMMPS's pair edpd has it: [w^D (γ u² − σ²/m) − σ w^R u ζ]/(C_i + C_j) for each, with u before the kick and
// without 1/√Δt at the noise. It conserves nothing.
//
// That form needs nothing of the end of the step and is summed while the forces are computed; the other one walks the
// pairs once more.
//
// Sums over a bead's pairs are integers on a grid, so that they do not depend on the order of the pairs.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/exact_sum.hpp"
#include "forces/pair_batch.hpp"
#include "meso/bead_process.hpp"
#include "meso/heat_motion_loops.hpp"
#include "meso/heat_pairs.hpp"

namespace dlpoly {

class ViscousHeating final : public BeadProcess, private MotionVisitor {
  public:
    enum class Form : std::uint8_t { conserving, lammps };

    ViscousHeating(std::shared_ptr<const HeatPairs> pairs, Form form)
        : pairs_(std::move(pairs)), form_(form), loops_(&heat_motion_loops()) {}

    // Afterwards the forces know of this object, which must live as long as they do.
    void start(State& state, Forces& forces, const StepSettings& settings) override;
    void advance(State& state, Forces& forces, const StepSettings& settings) override;

  private:
    struct Part {              // of a thread
        WideSum ahead;         // twice it
        double largest = 0.0;  // in units of the largest term that fits
        std::array<std::int64_t, batch_capacity + batch_lanes> heat_of_pair, ahead_of_pair;
        std::array<double, batch_capacity + batch_lanes> size;
    };

    // Writes the sums for the drag at these velocities.
    void walk(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity);
    void choose_grid(int exponent);
    void choose_usual_grid();
    void deposit(State& state) const;
    [[nodiscard]] double largest() const;
    void begin(const std::vector<std::uint32_t>& order, const Array3N& velocity, const ForceRequest& request,
               int threads) override;
    void visit(const PairBatch& batch, const BatchResult& result, int thread) override;

    std::shared_ptr<const HeatPairs> pairs_;
    Form form_;
    const HeatMotionLoops* loops_;
    // Of the present walk.
    const Particles* particles_ = nullptr;
    double timestep_ = 0.0;
    int exponent_ = 0;
    double scale_ = 1.0;
    double kicked_ = 1.0;            // 0 at a start: the present velocities are those of the drag
    std::uint64_t step_ = no_step;   // that the sums belong to
    std::vector<HeatedBead> beads_;  // sorted
    std::vector<std::int64_t> sums_;
    std::vector<std::uint32_t> order_;
    std::vector<Part> parts_;
    Array3N before_;

    static constexpr std::uint64_t no_step = ~std::uint64_t{0};
};

}  // namespace dlpoly
