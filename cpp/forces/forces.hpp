// The forces of a scene: the pair loop and whatever else the scene has; what is absent is not in the list.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "external/external_field.hpp"
#include "forces/pair_forces.hpp"

namespace dlpoly {

class Forces {
  public:
    explicit Forces(PairForces pairs) : pairs_(std::move(pairs)) {}

    void add(std::unique_ptr<ExternalField> field) { fields_.push_back(std::move(field)); }

    // Writes the total force on every bead; drag uses `velocity`. Totals are filled when the request observes.
    void compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                 PairTotals& totals) {
        pairs_.compute(box, particles, velocity, request, totals);
        for (const auto& field : fields_) {
            field->add(box, particles);
        }
    }

    [[nodiscard]] PairForces& pairs() noexcept { return pairs_; }
    [[nodiscard]] bool has_fields() const noexcept { return !fields_.empty(); }

  private:
    PairForces pairs_;
    std::vector<std::unique_ptr<ExternalField>> fields_;
};

}  // namespace dlpoly
