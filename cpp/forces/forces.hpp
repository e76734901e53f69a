// The forces of a scene: the pair loop, bonded terms and whatever else the scene has; what is absent is not in the
// list.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bonded/bonded_forces.hpp"
#include "charge/charge_forces.hpp"
#include "constraints/constraints.hpp"
#include "external/external_field.hpp"
#include "forces/pair_forces.hpp"

namespace dlpoly {

class Forces {
  public:
    explicit Forces(PairForces pairs) : pairs_(std::move(pairs)) {}

    void add(std::unique_ptr<ExternalField> field) { fields_.push_back(std::move(field)); }

    // Takes the bonded terms, and the pairs whose pair forces they replace.
    void set_bonded(BondedForces bonded, Exclusions exclusions) {
        bonded_ = std::move(bonded);
        pairs_.set_exclusions(std::move(exclusions));
    }

    // Forces of constraints are not among those that compute() writes: integrators meet them.
    void set_constraints(Constraints constraints) { constraints_ = std::move(constraints); }
    void set_charges(ChargeForces charges) { charges_.emplace(std::move(charges)); }

    // Writes the total force on every bead; drag uses `velocity`. Totals are filled when the request observes.
    void compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                 PairTotals& totals) {
        pairs_.compute(box, particles, velocity, request, totals);
        if (!request.conservative) {
            return;
        }
        if (bonded_ && !bonded_->empty()) {
            bonded_->add_to(box, particles, pairs_.table(), request.step, request.observe ? &bonded_totals_ : nullptr);
            if (request.observe) {
                totals.energy += bonded_totals_.energy[bonded::scaled_pairs];
                totals.conservative += bonded_totals_.virial[bonded::scaled_pairs];
            }
        }
        if (charges_) {
            charges_->add_to(box, particles, request.step, request.observe ? &charge_totals_ : nullptr);
        }
        double field_energy = 0.0;
        for (const auto& field : fields_) {
            field_energy += field->add(box, particles, request.time);
        }
        if (request.observe) {
            field_energy_ = field_energy;
        }
    }

    // Sets the velocities that fields prescribe.
    void steer(Particles& particles) const {
        for (const auto& field : fields_) {
            field->steer(particles);
        }
    }

    // Σ ∂²U/∂x² over the coordinates of all mobile beads.
    [[nodiscard]] double curvature(const Box& box, const Particles& particles) {
        double sum = pairs_.curvature(box, particles);
        sum += bonded_ ? bonded_->curvature(box, particles, pairs_.table()) : 0.0;
        sum += charges_ ? charges_->curvature(box, particles) : 0.0;
        for (const auto& field : fields_) {
            sum += field->curvature(particles);
        }
        return sum;
    }

    [[nodiscard]] PairForces& pairs() noexcept { return pairs_; }
    [[nodiscard]] bool has_bonded() const noexcept { return bonded_.has_value(); }
    [[nodiscard]] bool has_exclusions() const noexcept { return pairs_.has_exclusions(); }
    // nullptr: there are none.
    [[nodiscard]] BondedForces* bonded() noexcept { return bonded_ ? &*bonded_ : nullptr; }
    // nullptr: there are none.
    [[nodiscard]] Constraints* constraints() noexcept { return constraints_ ? &*constraints_ : nullptr; }
    [[nodiscard]] const Constraints* constraints() const noexcept { return constraints_ ? &*constraints_ : nullptr; }
    // Of the last observed step.
    [[nodiscard]] BondedTotals& bonded_totals() noexcept { return bonded_totals_; }
    [[nodiscard]] const BondedTotals& bonded_totals() const noexcept { return bonded_totals_; }
    // nullptr: no charges act.
    [[nodiscard]] ChargeForces* charges() noexcept { return charges_ ? &*charges_ : nullptr; }
    // Of the last observed step.
    [[nodiscard]] ChargeTotals& charge_totals() noexcept { return charge_totals_; }
    [[nodiscard]] const ChargeTotals& charge_totals() const noexcept { return charge_totals_; }
    [[nodiscard]] bool has_fields() const noexcept { return !fields_.empty(); }
    // Of the last observed step.
    [[nodiscard]] double field_energy() const noexcept { return field_energy_; }

  private:
    PairForces pairs_;
    std::optional<BondedForces> bonded_;
    std::optional<Constraints> constraints_;
    BondedTotals bonded_totals_;
    std::optional<ChargeForces> charges_;
    ChargeTotals charge_totals_;
    std::vector<std::unique_ptr<ExternalField>> fields_;
    double field_energy_ = 0.0;
};

}  // namespace dlpoly
