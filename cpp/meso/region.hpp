// A part of space or of the beads: where something is added.
#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "core/box.hpp"
#include "core/types.hpp"

namespace dlpoly {

class Region {
  public:
    enum class Kind : std::uint8_t { everywhere, species, box, sphere };

    static Region everywhere() { return Region(Kind::everywhere); }
    static Region of_species(std::int32_t species) {
        Region region(Kind::species);
        region.species_ = species;
        return region;
    }
    // Wrapped positions from `low` to below `high`; either may be infinite.
    static Region box(const Vector3& low, const Vector3& high) {
        if (!(low.array() < high.array()).all()) {
            throw std::invalid_argument("a box ends beyond where it begins");
        }
        Region region(Kind::box);
        region.low_ = low;
        region.high_ = high;
        return region;
    }
    // Up to `radius` from a point or its nearest image; at most half the cell's smallest width.
    static Region sphere(const Vector3& centre, double radius) {
        if (!(radius > 0.0 && centre.allFinite())) {
            throw std::invalid_argument("a sphere needs a radius larger than 0");
        }
        Region region(Kind::sphere);
        region.low_ = centre;
        region.radius_squared_ = radius * radius;
        return region;
    }

    [[nodiscard]] bool contains(const Box& cell, const Vector3& position, std::int32_t species) const {
        switch (kind_) {
            case Kind::everywhere:
                return true;
            case Kind::species:
                return species == species_;
            case Kind::box:
                return (position.array() >= low_.array() && position.array() < high_.array()).all();
            case Kind::sphere:
                break;
        }
        Vector3 apart = position - low_;
        const Vector3 s = cell.fractional(apart);
        for (int axis = 0; axis < 3; ++axis) {
            if (cell.periodic()[static_cast<std::size_t>(axis)]) {
                apart -= std::floor(s[axis] + 0.5) * cell.cell().row(axis).transpose();
            }
        }
        return apart.squaredNorm() <= radius_squared_;
    }

  private:
    explicit Region(Kind kind) : kind_(kind) {}

    Kind kind_;
    std::int32_t species_ = 0;
    Vector3 low_ = Vector3::Zero();
    Vector3 high_ = Vector3::Zero();
    double radius_squared_ = 0.0;
};

}  // namespace dlpoly
