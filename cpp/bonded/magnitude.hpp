// How large a bonded law's forces and energies are for beads at thermal energy. It only chooses the grid of the exact
// sums, so it looks at the law alone, never at a configuration: a run that is continued finds the same grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "bonded/law.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

struct Magnitude {
    double force = 0.0;
    double energy = 0.0;  // energies and virials
};

namespace detail {

struct Sample {
    double energy, force, virial;
};

// A law at coordinates that cover its range; angles are taken to act over a quarter of a length unit.
template <class Law>
std::vector<Sample> samples(const Law& law) {
    constexpr double lever = 4.0;
    std::vector<Sample> found;
    if constexpr (Law::info.kind == Kind::angle) {
        for (int k = 0; k < 64; ++k) {
            const AngleValue value = law((k + 0.5) * pi / 64, 1.0, 1.0);
            const double distances = std::max(std::abs(value.by_first), std::abs(value.by_second));
            found.push_back({value.energy, std::max(lever * std::abs(value.by_angle), distances), distances});
        }
    } else if constexpr (Law::info.kind == Kind::dihedral || (Law::info.kind == Kind::inversion && !Law::info.height)) {
        const double first = Law::info.kind == Kind::dihedral ? -pi : 0.0;
        const double range = Law::info.kind == Kind::dihedral ? 2.0 * pi : 0.5 * pi;
        for (int k = 0; k < 64; ++k) {
            const Value value = law(first + (k + 0.5) * range / 64);
            found.push_back({value.energy, lever * std::abs(value.slope), 0.0});
        }
    } else {
        for (int k = -48; k <= 48; ++k) {
            const double length = std::exp2(k / 8.0);
            const Value value = law(length);
            found.push_back({value.energy, std::abs(value.slope), std::abs(value.slope) * length});
        }
    }
    std::erase_if(found, [](const Sample& s) { return !std::isfinite(s.energy) || !std::isfinite(s.force); });
    return found;
}

}  // namespace detail

// The largest of both where U rises up to 50 k_B T above its minimum; without a temperature, a multiple of the middle.
template <class Law>
Magnitude magnitude(const Law& law, double thermal_energy) {
    std::vector<detail::Sample> found = detail::samples(law);
    if (found.empty()) return {};
    Magnitude largest;
    if (thermal_energy > 0.0) {
        const auto lowest = std::min_element(found.begin(), found.end(),
                                             [](const auto& a, const auto& b) { return a.energy < b.energy; });
        const double limit = lowest->energy + 50.0 * thermal_energy;
        for (const detail::Sample& sample : found) {
            if (sample.energy <= limit) {
                largest.force = std::max(largest.force, sample.force);
                largest.energy = std::max({largest.energy, std::abs(sample.energy), sample.virial});
            }
        }
        return largest;
    }
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end(),
                     [](const auto& a, const auto& b) { return a.force < b.force; });
    return {64.0 * middle->force, 64.0 * std::max(std::abs(middle->energy), middle->virial)};
}

}  // namespace dlpoly::bonded
