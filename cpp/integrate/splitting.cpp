// Splitting thermostats (see splitting.hpp).
#include "integrate/splitting.hpp"

#include "integrate/moves.hpp"
#include "integrate/piston.hpp"
#include "observe/kinetic.hpp"
#include "sweep/implicit_euler.hpp"
#include "sweep/lowe_andersen.hpp"
#include "sweep/ornstein_uhlenbeck.hpp"
#include "sweep/peters_first.hpp"
#include "sweep/shardlow.hpp"
#include "sweep/stoyanov_groot.hpp"

namespace dlpoly {

SweepSettings sweep_settings(const State& state, const StepSettings& settings, double duration, Stream stream) {
    SweepSettings sweep;
    sweep.duration = duration;
    sweep.thermal_energy = thermal_energy_now(state, settings);
    sweep.weight_exponent = settings.weight_exponent;
    sweep.transverse_drag = settings.transverse_drag;
    sweep.rate = settings.collision_rate;
    sweep.seed = settings.seed;
    sweep.step = state.step;
    sweep.shear_rate = settings.shear_rate;
    sweep.stream = stream;
    sweep.heat = settings.heat.get();
    sweep.strong_noise = settings.precision == Precision::reference;
    return sweep;
}

void Splitting::sweep(State& state, Forces& forces, const StepSettings& settings, double duration, Stream stream,
                      bool backward, bool observe) {
    SweepSettings told = sweep_settings(state, settings, duration, stream);
    told.backward = backward;
    told.observe = observe;
    Particles& particles = state.particles;
    enter_thermostat(state, forces, settings, backward ? 1 : 0);
    switch (order_) {
        case Order::zeroth:
            sweep_->apply(state.box, particles, sweep::ImplicitEuler{}, told);
            break;
        case Order::first:
        case Order::second:
            sweep_->apply(state.box, particles, sweep::Shardlow{}, told);
            break;
        case Order::peters_first:
            sweep_->apply(state.box, particles, sweep::PetersFirst{}, told);
            break;
        case Order::lowe_andersen:
            sweep_->apply(state.box, particles, sweep::LoweAndersen{}, told);
            break;
        case Order::stoyanov_groot: {
            const PairSweep::PairTemperature pairs = sweep_->measure(state.box, particles, told);
            const double present = pairs.weight > 0.0 ? pairs.energy / pairs.weight : 0.0;
            const double excess = present > 0.0 ? 1.0 - told.thermal_energy / present : 0.0;
            sweep_->apply(state.box, particles, sweep::StoyanovGroot{settings.thermostat_coupling * excess}, told);
            break;
        }
        default:
            sweep_->apply(state.box, particles, sweep::OrnsteinUhlenbeck{}, told);
    }
    leave_thermostat(state, forces, settings);
    virial_ += sweep_->virial();
    if (settings.heat) {
        state.heat_supplied -= sweep_->heat_of_held();
    }
}

void Splitting::step(State& state, Forces& forces, const StepSettings& settings, bool observe, PairTotals& totals) {
    if (!sweep_) {
        sweep_.emplace(forces.pairs().table(), forces.pairs().exclusions());
    }
    Particles& particles = state.particles;
    const double timestep = settings.timestep;
    const bool both = order_ == Order::second;
    const bool middle = order_ == Order::ou_middle;
    const bool before = both || order_ == Order::zeroth || order_ == Order::first || order_ == Order::ou;
    const bool due = state.step % static_cast<std::uint64_t>(settings.thermostat_every) == 0;
    virial_.setZero();
    std::optional<Matrix3> kinetic;
    if (before) {
        sweep(state, forces, settings, both ? 0.5 * timestep : timestep, Stream::sweep_words, false, observe);
    }
    push_piston(state, forces, totals, settings, 0.5 * timestep);
    kick(state, settings, 0.5 * timestep);
    if (!middle) {
        constrain_drift(state, forces, timestep);
        drift_through(state, settings);
    } else {
        constrain_drift(state, forces, 0.5 * timestep);
        drift(state, settings, 0.5 * timestep);
        enter_middle(state, settings);
        if (due) {
            sweep(state, forces, settings, timestep * settings.thermostat_every, Stream::sweep_words, false, observe);
        }
        constrain_velocities(state, forces, settings);
        if (observe) {
            kinetic = kinetic_tensor(particles, settings.shear_rate);
        }
        leave_middle(state, settings);
        constrain_drift(state, forces, 0.5 * timestep);
        drift(state, settings, 0.5 * timestep);
    }
    advance_clock(state, settings);
    compute_forces(state, forces, settings, conservative_request(state, settings, observe), particles.velocity, totals);
    kick(state, settings, 0.5 * timestep);
    constrain_velocities(state, forces, settings);
    push_piston(state, forces, totals, settings, 0.5 * timestep);
    if (both) {
        sweep(state, forces, settings, 0.5 * timestep, Stream::second_sweep, true, observe);
        virial_ *= 0.5;  // each of the two is a mean over half the step
    } else if (!before && !middle) {
        sweep(state, forces, settings, timestep, Stream::sweep_words, false, observe);
    }
    totals.drag = virial_;
    totals.kinetic = kinetic;
    finish_step(state, settings, forces.constraints());
}

}  // namespace dlpoly
