// One simulation (see system.hpp).
#include "integrate/system.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "integrate/equilibration.hpp"

namespace dlpoly {

System::System(State initial, Forces all_forces, StepSettings step_settings)
    : state(std::move(initial)),
      forces(std::move(all_forces)),
      settings(step_settings),
      integrator_(make_integrator(settings)) {
    settings.longest_move = forces.pairs().table().range();
}

void System::set_cell_width(double width) {
    cell_width_ = width;
    forces.pairs().set_cell_width(width);
    path_chosen_ = false;
    fluid_.reset();
}

void System::set_bonded(BondedForces terms, Exclusions exclusions) {
    forces.set_bonded(std::move(terms), std::move(exclusions));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::set_constraints(std::vector<Constraint> constraints, double tolerance, std::int64_t most_iterations) {
    forces.set_constraints(Constraints(std::move(constraints), state.particles, tolerance, most_iterations));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::meet_constraints() {
    if (Constraints* constraints = forces.constraints()) {
        constraints->settle(state.box, state.particles, state.step);
        constraints->after_kick(state.box, state.particles, settings.timestep, state.step);
        ready = false;
    }
}

void System::add_field(std::unique_ptr<ExternalField> field) {
    forces.add(std::move(field));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::set_flight(std::shared_ptr<const Flight> flight) {
    if (settings.flight) {
        throw std::invalid_argument("walls and a magnetic field cannot act together");
    }
    settings.flight = std::move(flight);
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::set_charges(ChargeForces charges) {
    forces.set_charges(std::move(charges));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::add_modifier(std::shared_ptr<PairModifier> modifier) {
    forces.pairs().add_modifier(std::move(modifier));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::add_process(std::unique_ptr<BeadProcess> process) {
    processes_.push_back(std::move(process));
    path_chosen_ = false;
    fluid_.reset();
    ready = false;
}

void System::set_many_body(std::shared_ptr<ManyBody> part) {
    if (many_body) {
        throw std::invalid_argument("many-body DPD is already there");
    }
    many_body = part;
    add_modifier(std::move(part));
}

void System::choose_path() {
    if (path_chosen_) {
        return;
    }
    path_chosen_ = true;
    refusal_ = settings.precision == Precision::reference ? "the precision is reference"
               : forces.constraints() != nullptr          ? "distances are fixed by constraints"
               : !forces.pairs().modifiers().empty()      ? "pair forces depend on more than distances"
               : !processes_.empty() || settings.heat     ? "beads carry heat or dissolved species"
               : forces.has_exclusions()
                   ? "bonded beads have no pair forces (keys without a leading '-')"
                   : fast::refusal(state.box, state.particles, forces.pairs().table(), settings, forces.has_fields());
    if (refusal_.empty()) {
        fluid_ = fast::make_fluid(state, forces.pairs().table(), settings, fast::chosen_passes(),
                                  settings.precision == Precision::mixed, cell_width_);
        if (forces.bonded() != nullptr) {
            fluid_->set_bonded(*forces.bonded(), forces.bonded_totals(), state.particles.species);
        }
        if (forces.charges() != nullptr && forces.charges()->charges().size() > 0) {
            fluid_->set_charges(*forces.charges(), forces.charge_totals());
        }
    }
}

std::string System::plan() {
    choose_path();
    return refusal_.empty() ? std::string("fast: ") + fast::chosen_passes().name : "general: " + refusal_;
}

void System::initialise() {
    choose_path();
    if (fluid_) {
        fluid_->start(state, settings, totals);
    } else {
        integrator_->start(state, forces, settings, true, totals);
        for (const auto& process : processes_) {
            process->start(state, forces, settings);
        }
    }
    ready = true;
}

void System::run(std::uint64_t steps) {
    if (!ready) {
        initialise();
    }
    const auto until_multiple = [this](std::uint64_t interval, std::uint64_t most) {
        return interval > 0 ? std::min(most, interval - state.step % interval) : most;
    };
    ready = false;  // until all steps are taken: one that fails leaves forces of other positions
    while (steps > 0) {
        // The fast path stops where something looks at the beads or changes them between steps.
        std::uint64_t stride = fluid_ ? until_multiple(distances ? distances_every : 0, steps) : 1;
        if (state.step < settings.equilibration_steps) {
            stride = std::min(
                {until_multiple(settings.rescale_every, stride), until_multiple(settings.regauss_every, stride)});
        }
        if (fluid_) {
            fluid_->run(state, settings, stride, totals);
            equilibrate(state, settings);
        } else {
            integrator_->step(state, forces, settings, steps == 1, totals);
            for (const auto& process : processes_) {
                process->advance(state, forces, settings);
            }
        }
        steps -= stride;
        if (distances && distances_every > 0 && state.step > distances_after && state.step % distances_every == 0) {
            distances->sample(state.box, state.particles);
        }
    }
    ready = true;
}

void System::enable_distances(double range, std::int32_t bins, std::uint64_t every, std::uint64_t after) {
    distances.emplace(forces.pairs().table().species(), range, bins);
    distances_every = every;
    distances_after = after;
}

}  // namespace dlpoly
