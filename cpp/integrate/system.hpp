// One simulation: state, forces, integrator, and what was observed in the last step that was asked to observe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/state.hpp"
#include "external/external_field.hpp"
#include "external/flight.hpp"
#include "fast/fluid.hpp"
#include "forces/forces.hpp"
#include "integrate/integrator.hpp"
#include "integrate/step_settings.hpp"
#include "meso/bead_process.hpp"
#include "meso/many_body.hpp"
#include "observe/pair_distances.hpp"

namespace dlpoly {

class System {
  public:
    System(State state, Forces forces, StepSettings settings);

    // Forces at the present positions and velocities, observed; `drag` as the settings have it.
    void initialise();

    // Takes `steps` steps and observes the last one. Samples pair distances in steps divisible by distances_every,
    // later than distances_after.
    void run(std::uint64_t steps);

    // Link cells of at least this width instead of one range; 0 = one range. Changes speed, never results.
    void set_cell_width(double width);

    // Takes bonded terms, and the pairs of beads whose pair forces they replace.
    void set_bonded(BondedForces terms, Exclusions exclusions);

    // Takes distances that stay fixed; positions and velocities are left as they are.
    void set_constraints(std::vector<Constraint> constraints, double tolerance, std::int64_t most_iterations);

    // Brings positions to the lengths of the constraints, and takes out of velocities what would change them.
    void meet_constraints();
    // Adds an external field; sets how beads move between kicks, which one thing alone may. The second throws
    // std::invalid_argument where something does already.
    void add_field(std::unique_ptr<ExternalField> field);
    void set_flight(std::shared_ptr<const Flight> flight);
    // Takes the electrostatics.
    void set_charges(ChargeForces charges);
    // Adds a part of the pair forces that needs more than distances, and what happens to what beads carry in a step.
    void add_modifier(std::shared_ptr<PairModifier> modifier);
    void add_process(std::unique_ptr<BeadProcess> process);
    // Adds many-body DPD. Throws std::invalid_argument where there is one already.
    void set_many_body(std::shared_ptr<ManyBody> part);

    // How steps are computed: "fast", or why not in words.
    [[nodiscard]] std::string plan();

    void enable_distances(double range, std::int32_t bins, std::uint64_t every, std::uint64_t after);

    State state;
    Forces forces;
    StepSettings settings;
    PairTotals totals;
    std::optional<PairDistances> distances;
    std::uint64_t distances_every = 0;
    std::uint64_t distances_after = 0;
    std::shared_ptr<const ManyBody> many_body;  // nullptr: no local densities
    bool ready = false;                         // forces belong to the present positions

  private:
    void choose_path();
    double cell_width_ = 0.0;

    std::unique_ptr<Integrator> integrator_;
    std::vector<std::unique_ptr<BeadProcess>> processes_;
    bool path_chosen_ = false;
    std::string refusal_;
    std::unique_ptr<fast::Fluid> fluid_;  // nullptr: the general path
};

}  // namespace dlpoly
