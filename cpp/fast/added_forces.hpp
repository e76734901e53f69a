// Bonded terms and electrostatics on the fast path: forces that are computed apart from the passes over pairs, from
// positions by id, and handed to them as impulses.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <vector>

#include "bonded/bonded_forces.hpp"
#include "charge/charge_forces.hpp"
#include "core/state.hpp"
#include "fast/arguments.hpp"
#include "fast/units.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly::fast {

template <class Record>
class AddedForces {
  public:
    // The table must outlive this.
    AddedForces(const Units& units, double timestep, const PairTable& table)
        : units_(units), timestep_(timestep), table_(table) {}

    void set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species);
    void set_charges(ChargeForces& charges, ChargeTotals& totals);

    // Beads below it may have such forces; 0: none have.
    [[nodiscard]] std::uint32_t end() const noexcept { return end_; }

    // Takes note of a bead's position for the next forces.
    void place(const Record& bead) {
        const std::size_t id = bead.tag & id_mask;
        if (id >= end_) {
            return;
        }
        const std::array<typename Record::Fixed, 3> position{bead.x, bead.y, bead.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double edge = units_.edges[static_cast<Eigen::Index>(axis)];
            positions_[3 * id + axis] = coordinate<Record>(position[axis], edge);
        }
    }

    // Before the steps of a chunk: no more threads than this will come.
    void restart(int threads);
    // The same, by all threads together, once their number is known.
    void prepare(std::size_t parts);
    // Tells a pass where the impulses are.
    void describe(PassArguments<Record>& a);

    // Computes the forces of the noted positions. Called by all threads together; false in all of them when forces
    // cannot be computed.
    bool compute(const State& state, std::size_t part, std::size_t parts, std::uint64_t step, bool observe);

    // After the steps of a chunk, of which the last, `step`, was observed in `parts` parts: writes the totals. Throws
    // what a step failed with; true: a step's impulses left their range.
    bool finish(const State& state, std::size_t parts, std::uint64_t step);

  private:
    void make_room(std::uint32_t end);
    [[nodiscard]] bonded::Request request(bool observe, int energy_exponent) const;
    bool add_bonded(const State& state, std::size_t part, std::size_t parts, bool observe);
    bool add_charges(const State& state, std::uint64_t step, bool observe);
    void observe_bonded(const State& state, std::size_t parts);

    Units units_;
    double timestep_;
    const PairTable& table_;
    BondedForces* bonded_ = nullptr;
    BondedTotals* bonded_totals_ = nullptr;
    std::vector<std::int32_t> species_;
    ChargeForces* charges_ = nullptr;
    ChargeTotals* charge_totals_ = nullptr;
    std::uint32_t end_ = 0;
    std::vector<double> positions_;       // 3 a bead, by id
    std::vector<std::int64_t> impulses_;  // 3 a bead, by id, zeros between steps
    std::vector<bonded::Worker> workers_;
    std::atomic<bool> charges_stop_{false};
    std::exception_ptr charge_failure_;
};

}  // namespace dlpoly::fast
