// The configurational temperature (see configurational.hpp).
#include "observe/configurational.hpp"

#include <utility>

namespace dlpoly {

Configurational configurational(State& state, Forces& forces) {
    Particles& particles = state.particles;
    Array3N kept = particles.force;
    ForceRequest request;
    request.step = state.step;
    request.time = state.time;
    PairTotals unused;
    forces.compute(state.box, particles, particles.velocity, request, unused);
    Configurational result;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (particles.frozen[static_cast<std::size_t>(i)] == 0) {
            result.squared_force += particles.force.row(i).squaredNorm();
        }
    }
    result.curvature = forces.curvature(state.box, particles);
    particles.force = std::move(kept);
    return result;
}

}  // namespace dlpoly
