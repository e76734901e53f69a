// External fields: forces on single beads that depend on position and mass only. One field, one small class.
#pragma once

#include <memory>
#include <span>
#include <string>

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

    // Adds the field's force to every bead that is not frozen.
    virtual void add(const Box& box, Particles& particles) const = 0;
};

// The field with DL_POLY's key ("grav", "oshr"). Throws std::invalid_argument for an unknown key or missing numbers.
std::unique_ptr<ExternalField> make_external_field(const std::string& key, std::span<const double> parameters);

}  // namespace dlpoly
