// Heat from drag and noise that are forces (see viscous_heating.hpp).
#include "meso/viscous_heating.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/failure.hpp"
#include "integrate/moves.hpp"

namespace dlpoly {

void ViscousHeating::choose_grid(int exponent) {
    exponent_ = exponent;
    scale_ = std::ldexp(1.0, exponent);
}

// Heat is a multiple of k_B T for all but wild starts.
void ViscousHeating::choose_usual_grid() { choose_grid(grid_exponent(std::max(pairs_->reference(), 1e-200))); }

void ViscousHeating::begin(const std::vector<std::uint32_t>& order, const Array3N& velocity,
                           const ForceRequest& request, int threads) {
    step_ = request.step;
    order_ = order;
    parts_.resize(static_cast<std::size_t>(threads));
    for (Part& part : parts_) {
        part.ahead = WideSum();
        part.largest = 0.0;
    }
    sums_.assign(order.size(), 0);
    beads_.resize(order.size());
    const Particles& particles = *particles_;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < order.size(); ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        HeatedBead& bead = beads_[k];
        bead.mass = particles.mass[order[k]];
        bead.capacity = particles.heat_capacity[order[k]];
        bead.temperature = particles.temperature[order[k]];
        const double kick = 0.5 * timestep_ * particles.inverse_mass(id);
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            bead.before[axis] = velocity(id, axis);
            bead.change[axis] = kick * particles.force(id, axis);
        }
    }
}

void ViscousHeating::visit(const PairBatch& batch, const BatchResult& result, int thread) {
    Part& part = parts_[static_cast<std::size_t>(thread)];
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    const HeatOfMotion loop{{batch.i.values, batch.j.values, batch.distance_squared.values, whole},
                            beads_.data(),
                            batch.dx.values,
                            batch.dy.values,
                            batch.dz.values,
                            result.drag.values,
                            result.noise.values,
                            timestep_,
                            kicked_,
                            scale_,
                            part.heat_of_pair.data(),
                            part.ahead_of_pair.data(),
                            part.size.data()};
    if (!(form_ == Form::lammps ? loops_->lammps : loops_->conserving)(loop)) {
        double largest = 0.0;
        for (std::size_t k = 0; k < batch.size; ++k) {
            largest = std::max(largest, std::isfinite(part.size[k]) ? part.size[k] : HUGE_VAL);
        }
        part.largest = std::max(part.largest, largest);
        if (largest >= 1.0) {
            return;  // the sums are made once more
        }
    }
    for (std::size_t r = 0; r < batch.runs; ++r) {
        const PairRun& run = batch.run.values[r];
        std::int64_t own = 0;
        for (std::uint32_t k = run.begin; k < run.end; ++k) {
            own += part.heat_of_pair[k];
            sums_[batch.j.values[k]] += part.heat_of_pair[k];
        }
        sums_[run.bead] += own;
    }
    if (form_ == Form::conserving) {
        std::int64_t ahead = 0;
        for (std::size_t k = 0; k < batch.size; ++k) {
            ahead += part.ahead_of_pair[k];
        }
        part.ahead.add(ahead);
    }
}

double ViscousHeating::largest() const {
    double largest = 0.0;
    for (const Part& part : parts_) {
        largest = std::max(largest, part.largest);
    }
    return largest;
}

void ViscousHeating::walk(State& state, Forces& forces, const StepSettings& settings, const Array3N& velocity) {
    const ForceRequest request = request_of(state, settings, false);
    choose_usual_grid();
    for (bool fits = false; !fits;) {
        parts_.clear();  // where there are no pairs there is nothing to begin
        forces.pairs().visit_motion(state.box, state.particles, velocity, request, *this);
        const double most = largest();
        if (!std::isfinite(most)) {
            throw RunFailure("step " + std::to_string(state.step) +
                             ": the heat of drag and noise is not finite; the timestep is too long for the drag");
        }
        fits = most < 1.0;
        if (!fits) {
            choose_grid(exponent_ - std::ilogb(most) - 1);
        }
    }
    WideSum ahead;
    for (const Part& part : parts_) {
        ahead.add(part.ahead);
    }
    state.heat_ahead = ahead.value(exponent_);
}

void ViscousHeating::start(State& state, Forces& forces, const StepSettings& settings) {
    state.heat_ahead = 0.0;
    particles_ = &state.particles;
    timestep_ = settings.timestep;
    if (form_ != Form::conserving) {
        choose_usual_grid();
        step_ = no_step;
        forces.pairs().watch_motion(this);
        return;
    }
    // The drag is that of the present velocities. No bead is charged: only what the first half kick does is noted.
    kicked_ = 0.0;
    walk(state, forces, settings, state.particles.velocity);
    kicked_ = 1.0;
}

void ViscousHeating::advance(State& state, Forces& forces, const StepSettings& settings) {
    const bool seen = form_ == Form::lammps && step_ == state.step && timestep_ == settings.timestep &&
                      particles_ == &state.particles && largest() < 1.0;
    particles_ = &state.particles;
    timestep_ = settings.timestep;
    if (!seen) {
        Particles& particles = state.particles;
        before_.resize(particles.count(), 3);
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            before_.row(i) = particles.velocity.row(i) -
                             0.5 * settings.timestep * particles.inverse_mass(i) * particles.force.row(i);
        }
        walk(state, forces, settings, before_);
    }
    deposit(state);
    choose_usual_grid();
}

void ViscousHeating::deposit(State& state) const {
    Particles& particles = state.particles;
    for (std::size_t k = 0; k < order_.size(); ++k) {
        const std::uint32_t id = order_[k];
        const double heat = static_cast<double>(sums_[k]) / scale_;
        if (pairs_->held[id] != 0) {
            state.heat_supplied -= heat;
            continue;
        }
        const double temperature = particles.temperature[id] + heat / particles.heat_capacity[id];
        if (!(temperature > 0.0)) {
            throw RunFailure("step " + std::to_string(state.step) + ": drag and noise take more heat from bead " +
                             std::to_string(id + 1) +
                             " than it has; the timestep is too long for its heat capacity, or take an integrator "
                             "that sweeps over pairs");
        }
        particles.temperature[id] = temperature;
    }
}

}  // namespace dlpoly
