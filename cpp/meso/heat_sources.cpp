// Sources and sinks of heat (see heat_sources.hpp).
#include "meso/heat_sources.hpp"

#include <algorithm>

namespace dlpoly {

namespace {

struct Inside {
    const State& state;
    std::size_t bead;

    bool operator()(const HeatBox& box) const {
        const auto row = static_cast<Eigen::Index>(bead);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = state.particles.position(row, static_cast<Eigen::Index>(axis));
            if (!(x >= box.low[axis] && x < box.high[axis])) {
                return false;
            }
        }
        return true;
    }
    bool operator()(const HeatSphere& sphere) const {
        const auto row = static_cast<Eigen::Index>(bead);
        const Vector3 apart = state.particles.position.row(row).transpose() - sphere.centre;
        return apart.squaredNorm() < sphere.radius * sphere.radius;
    }
    bool operator()(const HeatSpecies& one) const { return state.particles.species[bead] == one.species; }
};

}  // namespace

void HeatSources::advance(State& state, Forces& /*forces*/, const StepSettings& settings) {
    Particles& particles = state.particles;
    for (std::size_t bead = 0; bead < particles.temperature.size(); ++bead) {
        if (pairs_->held[bead] != 0) {
            continue;
        }
        double rate = 0.0;
        for (const HeatSource& source : sources_) {
            rate += std::visit(Inside{state, bead}, source.where) ? source.rate : 0.0;
        }
        const double change = std::max(rate * settings.timestep, -0.5 * particles.temperature[bead]);
        particles.temperature[bead] += change;
        state.heat_supplied += particles.heat_capacity[bead] * change;
    }
}

}  // namespace dlpoly
