// How beads move between two kicks where that is not along a straight line. One flight, one small class.
#pragma once

#include "core/particles.hpp"

namespace dlpoly {

class Flight {
  public:
    Flight() = default;
    Flight(const Flight&) = delete;
    Flight& operator=(const Flight&) = delete;
    Flight(Flight&&) = delete;
    Flight& operator=(Flight&&) = delete;
    virtual ~Flight() = default;

    // Where the bead is after this time, ps; gives it the velocity it has there. Other beads are not touched.
    [[nodiscard]] virtual Vector3 move(Particles& particles, Eigen::Index bead, double time) const = 0;
};

}  // namespace dlpoly
