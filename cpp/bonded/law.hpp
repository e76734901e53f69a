// What every bonded law provides; one law = one header in this folder + one line in registry.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace dlpoly::bonded {

enum class Kind { bond, angle, dihedral, inversion, tether };

inline constexpr std::size_t kinds = 5;
inline constexpr std::array<std::string_view, kinds> kind_names{"bond", "angle", "dihedral", "inversion", "tether"};
inline constexpr std::array<std::size_t, kinds> beads_of_kind{2, 3, 4, 4, 1};

inline constexpr std::size_t index(Kind kind) noexcept { return static_cast<std::size_t>(kind); }
inline constexpr std::string_view name(Kind kind) noexcept { return kind_names[index(kind)]; }

// U and its derivative with respect to the law's one coordinate.
struct Value {
    double energy;
    double slope;
};

// U of an angle and its derivatives with respect to the angle and the distances of both ends from the vertex.
struct AngleValue {
    double energy;
    double by_angle;
    double by_first = 0.0;
    double by_second = 0.0;
};

// How the numbers of a FIELD record map onto a law. All numbers reach the law in internal units and radians.
struct LawInfo {
    Kind kind;
    std::string_view key;            // DL_POLY's four-letter key
    std::string_view restraint_key;  // the same law whose beads keep their pair forces; empty when there is none
    std::string_view description;    // one line for tables and messages
    std::span<const std::string_view> parameter_names;
    unsigned energy_mask;         // bit k set: parameter k is an energy and is scaled by FIELD's unit
    unsigned degree_mask = 0;     // bit k set: parameter k is an angle, in degrees in FIELD
    unsigned optional = 0;        // so many of the last parameters may be left out; they are then 0
    std::string_view limit = "";  // what it means when U is not finite
    bool height = false;          // inversions: the coordinate is the distance of the centre from the plane
    bool table = false;           // its numbers are a table: a start, a spacing, energies, slopes
};

// A law is a small value type:
//   static constexpr LawInfo info;
//   explicit Law(std::span<const double> parameters);  throws std::invalid_argument naming the parameter
// and, by kind, one of
//   Value operator()(double length) const noexcept;       bonds, and tethers at the displacement from the anchor
//   AngleValue operator()(double angle, double first, double second) const noexcept;       angle in [0, π]
//   Value operator()(double angle) const noexcept;        dihedrals in (−π, π], inversions in [0, π/2]
//   Value operator()(double height) const noexcept;       inversions whose info says height
// A result that is not finite stops the run with the names of the beads.

}  // namespace dlpoly::bonded
