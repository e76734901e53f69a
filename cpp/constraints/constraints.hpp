// Pairs of beads at fixed distances: SHAKE and RATTLE (Ryckaert, Ciccotti and Berendsen, J. Comput. Phys. 23, 327
// (1977); Andersen, J. Comput. Phys. 52, 24 (1983)).
//
// Both act on velocities: before a drift so that it ends with the right lengths, after a kick so that none of them
// changes. Beads that constraints connect make a cluster; clusters know nothing of each other, so that results are the
// same bits for any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "core/box.hpp"
#include "core/particles.hpp"
#include "core/types.hpp"

namespace dlpoly {

struct Constraint {
    std::uint32_t i, j;
    double length;
};

// Where velocities are drawn from.
struct MaxwellDraw {
    double thermal_energy;  // k_B T
    std::uint64_t seed, step;
};

class Constraints {
  public:
    // Takes constraints between beads of which at least one can move; those of two frozen beads are left out.
    // Throws std::invalid_argument for beads that do not exist or are the same, and for numbers that are not positive.
    Constraints(std::vector<Constraint> constraints, const Particles& particles, double tolerance,
                std::int64_t most_iterations);

    // Changes velocities along the present directions so that a drift by `time` ends with all lengths within the
    // tolerance. This and the next two throw RunFailure naming the beads where the iteration does not end.
    void before_drift(const Box& box, Particles& particles, double time, std::uint64_t step);

    // Takes out of the velocities what would change a length by more than the tolerance in `timestep`.
    void after_kick(const Box& box, Particles& particles, double timestep, std::uint64_t step);

    // Adds to velocities that change no length what is missing of the Maxwell distribution of free beads: a thermostat
    // that keeps that one, pair by pair, and after_kick then keep the distribution that constraints leave. `part` tells
    // the thermostat's parts in one step from each other.
    void release(const Box& box, Particles& particles, const MaxwellDraw& draw, std::uint32_t part, double timestep);

    // Moves beads along the present directions to the right lengths. They are wrapped into the cell.
    void settle(const Box& box, Particles& particles, std::uint64_t step);

    // Σ F_a r_b of the forces that hold the lengths against the present forces and velocities (solved directly).
    [[nodiscard]] Matrix3 virial(const Box& box, const Particles& particles) const;

    // The largest difference between a distance and its length.
    [[nodiscard]] double deviation(const Box& box, const Particles& particles) const;

    [[nodiscard]] std::size_t size() const noexcept { return constraints_.size(); }

  private:
    struct Range {
        std::size_t first, last;
    };

    void find_arms(const Box& box, const Particles& particles, std::vector<Vector3>& arms) const;
    void before_move(const Box& box, const Particles& particles, Array3N& velocity, double time, std::uint64_t step);
    bool keep_lengths(Range cluster, Array3N& velocity, double time) const;
    bool keep_directions(Range cluster, Array3N& velocity, double timestep) const;
    template <class Solve>
    void solve_all(const Solve& solve, const Array3N& velocity, double time, const char* what,
                   std::uint64_t step) const;
    void multipliers(Range cluster, const Particles& particles, const std::vector<Vector3>& arms,
                     std::vector<double>& found) const;
    [[noreturn]] void fail(Range cluster, const Array3N& velocity, double time, const char* what,
                           std::uint64_t step) const;

    std::vector<Constraint> constraints_;  // cluster by cluster, in the given order within one
    std::vector<std::size_t> start_;       // cluster k has constraints start_[k] … start_[k + 1]
    std::vector<double> inverse_mass_;     // one a bead
    std::vector<std::uint32_t> beads_;     // those that constraints hold and that can move
    double tolerance_;
    std::int64_t most_iterations_;
    Array3N drawn_;
    Array3N kept_;
    std::vector<Vector3> arms_;  // r_i − r_j of the move under way
};

}  // namespace dlpoly
