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
// Sums over a bead's pairs are integers on a grid, so that they do not depend on the order of the pairs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/exact_sum.hpp"
#include "meso/bead_process.hpp"
#include "meso/heat_pairs.hpp"

namespace dlpoly {

class ViscousHeating final : public BeadProcess, private MotionVisitor {
  public:
    enum class Form : std::uint8_t { conserving, lammps };

    ViscousHeating(std::shared_ptr<const HeatPairs> pairs, Form form) : pairs_(std::move(pairs)), form_(form) {}

    void start(State& state, Forces& forces, const StepSettings& settings) override;
    void advance(State& state, Forces& forces, const StepSettings& settings) override;

  private:
    struct Bead {
        Vector3 before;  // velocity that the drag was computed from
        Vector3 change;  // of half a kick
        double mass;
        double capacity;
        double thermal_energy;  // k_B T of the bead
    };
    struct Part {  // of a thread
        WideSum ahead;
        double largest = 0.0;  // in units of the largest term that fits
    };

    // Writes the sums for the drag at these velocities.
    void walk(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity);
    void deposit(State& state) const;
    void begin(const std::vector<std::uint32_t>& order, int threads) override;
    void visit(const PairBatch& batch, const BatchResult& result, int thread) override;
    // Twice what each of two beads is given, and of it what the next half kick will do.
    struct Work {
        double heat;
        double ahead;
    };
    [[nodiscard]] Work work(const PairBatch& batch, const BatchResult& result, std::size_t k) const;

    std::shared_ptr<const HeatPairs> pairs_;
    Form form_;
    // Of the present walk.
    const Particles* particles_ = nullptr;
    const Array3N* velocity_ = nullptr;
    double timestep_ = 0.0;
    double scale_ = 1.0;
    double kicked_ = 1.0;      // 0 at a start: the present velocities are those of the drag
    std::vector<Bead> beads_;  // sorted
    std::vector<std::int64_t> sums_;
    std::vector<std::uint32_t> order_;
    std::vector<Part> parts_;
    Array3N before_;
};

}  // namespace dlpoly
