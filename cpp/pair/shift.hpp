// The force shift of a whole run: U_s = U − U(rc) + F(rc) (r − rc), F_s = F − F(rc), as two constants per pair law.
#pragma once

#include <cmath>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"

namespace dlpoly::pair {

// Added to a pair's value as U + energy + force · r and F − force; both zero: not shifted.
struct Shift {
    double energy = 0.0;
    double force = 0.0;
};

// Laws that end by themselves with zero force are left alone, as DL_POLY does (LawInfo::shiftable).
template <class Law>
Shift shift_of(const Law& law, double cutoff) {
    if constexpr (!Law::info.shiftable) {
        return {};
    } else {
        const PairValue end = law(cutoff * cutoff);
        const double force = end.force_over_r * cutoff;
        return {-end.energy - force * cutoff, force};
    }
}

// The pair loop's use of a shift; a coincident pair keeps force 0.
inline PairValue shifted(PairValue value, Shift shift, double distance_squared) noexcept {
    const double distance = std::sqrt(distance_squared);
    return {value.energy + shift.energy + shift.force * distance,
            value.force_over_r - shift.force * inverse_or_zero(distance)};
}

}  // namespace dlpoly::pair
