// How the fast path takes steps: what of the settings decides between its passes.
#pragma once

#include <cstdint>

#include "forces/pair_table.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly::fast {

struct Scheme {
    double timestep;
    bool has_drag;
    bool middle;  // drag and noise act in the middle of the drift, every so many steps
    int every;
    bool predicts;      // the drag sees velocities ahead of the half step's: Groot and Warren's λ is not ½
    double prediction;  // λ − ½
    bool half_kinetic;  // the kinetic energy is that of the half-step velocities

    [[nodiscard]] bool thermostat_due(std::uint64_t step) const {
        return middle && has_drag && step % static_cast<std::uint64_t>(every) == 0;
    }
};

inline Scheme make_scheme(const PairTable& table, const StepSettings& settings) {
    const bool middle = settings.order == Order::middle;
    return {.timestep = settings.timestep,
            .has_drag = settings.drag && table.has_drag(),
            .middle = middle,
            .every = middle ? settings.thermostat_every : 1,
            .predicts = settings.order == Order::velocity_verlet && settings.drag && settings.prediction != 0.5,
            .prediction = settings.prediction - 0.5,
            .half_kinetic = settings.half_step_kinetic};
}

}  // namespace dlpoly::fast
