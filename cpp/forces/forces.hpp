// The forces of a scene: the pair loop, bonded terms and whatever else the scene has; what is absent is not in the
// list.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bonded/bonded_forces.hpp"
#include "charge/charge_forces.hpp"
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

    void set_charges(ChargeForces charges) { charges_.emplace(std::move(charges)); }

    // Writes the total force on every bead; drag uses `velocity`. Totals are filled when the request observes.
    void compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                 PairTotals& totals) {
        pairs_.compute(box, particles, velocity, request, totals);
        if (!request.conservative) {
            return;
        }
        if (bonded_) {
            bonded_->add_to(box, particles, pairs_.table(), request.step, request.observe ? &bonded_totals_ : nullptr);
            if (request.observe) {
                totals.energy += bonded_totals_.energy[bonded::scaled_pairs];
                totals.conservative += bonded_totals_.virial[bonded::scaled_pairs];
            }
        }
        if (charges_) {
            charges_->add_to(box, particles, request.step, request.observe ? &charge_totals_ : nullptr);
        }
        for (const auto& field : fields_) {
            field->add(box, particles);
        }
    }

    // Σ ∂²U/∂x² over the coordinates of all mobile beads; external fields have none.
    [[nodiscard]] double curvature(const Box& box, const Particles& particles) {
        return pairs_.curvature(box, particles) + (bonded_ ? bonded_->curvature(box, particles, pairs_.table()) : 0.0) +
               (charges_ ? charges_->curvature(box, particles) : 0.0);
    }

    [[nodiscard]] PairForces& pairs() noexcept { return pairs_; }
    [[nodiscard]] bool has_bonded() const noexcept { return bonded_.has_value(); }
    [[nodiscard]] bool has_exclusions() const noexcept { return pairs_.has_exclusions(); }
    // nullptr: there are none.
    [[nodiscard]] BondedForces* bonded() noexcept { return bonded_ ? &*bonded_ : nullptr; }
    // Of the last observed step.
    [[nodiscard]] BondedTotals& bonded_totals() noexcept { return bonded_totals_; }
    [[nodiscard]] const BondedTotals& bonded_totals() const noexcept { return bonded_totals_; }
    // nullptr: no charges act.
    [[nodiscard]] ChargeForces* charges() noexcept { return charges_ ? &*charges_ : nullptr; }
    // Of the last observed step.
    [[nodiscard]] ChargeTotals& charge_totals() noexcept { return charge_totals_; }
    [[nodiscard]] const ChargeTotals& charge_totals() const noexcept { return charge_totals_; }
    [[nodiscard]] bool has_fields() const noexcept { return !fields_.empty(); }

  private:
    PairForces pairs_;
    std::optional<BondedForces> bonded_;
    BondedTotals bonded_totals_;
    std::optional<ChargeForces> charges_;
    ChargeTotals charge_totals_;
    std::vector<std::unique_ptr<ExternalField>> fields_;
};

}  // namespace dlpoly
