// Two plane walls across each of some axes, at equal distances on both sides of the origin.
#pragma once

#include <array>

#include "core/types.hpp"

namespace dlpoly {

struct WallPlanes {
    std::array<bool, 3> walled{};        // which axes have walls
    Vector3 distance = Vector3::Zero();  // of the walls from the origin, Å
};

}  // namespace dlpoly
