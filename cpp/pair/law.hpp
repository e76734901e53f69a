// What every pair law provides; one law = one header in this folder + one line in registry.hpp.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string_view>

namespace dlpoly::pair {

// U(r) and g = −(1/r) dU/dr, so that the force on i is g · (r_i − r_j) and the pair's virial part Σ r·F is g r².
struct PairValue {
    double energy;
    double force_over_r;
};

// How the numbers of a FIELD record map onto a law. All numbers reach the law in internal units.
struct LawInfo {
    std::string_view key;          // DL_POLY's four-letter key
    std::string_view description;  // one line for tables and messages
    std::span<const std::string_view> parameter_names;
    unsigned energy_mask;   // bit k set: parameter k is an energy and is scaled by FIELD's unit
    int drag_slot;          // 1-based position of γ in the record; 0: the record has no room for it
    bool soft;              // finite at r = 0: coincident beads are legal (force 0)
    bool has_tail;          // DL_POLY adds a long-range correction beyond the cutoff
    bool mixable = false;   // missing cross terms can be made from the two self terms (mixing.hpp)
    bool shiftable = true;  // FIELD-wide force shift applies (shift.hpp); false: the law ends by itself
};

// A law is a small value type:
//   static constexpr LawInfo info;
//   Law(std::span<const double> parameters, double cutoff);  throws std::invalid_argument naming the parameter
//   double range() const;               where the law itself ends, or 0 when it ends at the run's cutoff
//   PairValue operator()(double distance_squared) const noexcept;
// and, where DL_POLY's long-range correction is not the integral of the law itself,
//   Tail tail(double cutoff) const;  see tail.hpp
// and, where the law owns memory,
//   auto evaluator() const;  a value type with the same operator()
// A soft law returns force_over_r = 0 at r = 0; a hard law may return infinities there, which the pair loop reports.

// What the pair loop evaluates: a copy of the law, or whatever Law::evaluator() returns, for a law whose own copies are
// not plain numbers.
template <class Law>
auto evaluator(const Law& law) noexcept {
    if constexpr (requires { law.evaluator(); }) {
        return law.evaluator();
    } else {
        return law;
    }
}

}  // namespace dlpoly::pair
