// External fields: forces on single beads that depend on position, mass, charge and time only. One field, one small
// class. Fields that turn velocities are flights (see flight.hpp).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/box.hpp"
#include "core/particles.hpp"

namespace dlpoly {

class ExternalField {
  public:
    ExternalField() = default;
    ExternalField(const ExternalField&) = delete;
    ExternalField& operator=(const ExternalField&) = delete;
    ExternalField(ExternalField&&) = delete;
    ExternalField& operator=(ExternalField&&) = delete;
    virtual ~ExternalField() = default;

    // Adds the field's force at a time to every bead that is not frozen. Returns the energy of all beads in it; 0 for
    // fields that have none in a periodic cell, as in DL_POLY.
    virtual double add(const Box& box, Particles& particles, double time) const = 0;

    // Σ ∂²U/∂x² over the coordinates of the mobile beads.
    [[nodiscard]] virtual double curvature(const Particles& /*particles*/) const { return 0.0; }

    // Sets the velocities that the field prescribes; called once for every step's forces.
    virtual void steer(Particles& /*particles*/) const {}
};

// The field with DL_POLY's key, or our own `pois`. `charges` (one a bead) are asked for by elec and osel alone. Throws
// std::invalid_argument for an unknown key, missing numbers or another number of charges than the field takes.
std::unique_ptr<ExternalField> make_external_field(const std::string& key, std::span<const double> parameters,
                                                   std::vector<double> charges);

}  // namespace dlpoly
