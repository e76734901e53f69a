// A/r¹² − B/r⁶, the arithmetic that lj, ljc, 12-6 and their tapered forms share.
#pragma once

#include "pair/law.hpp"

namespace dlpoly::pair {

struct TwelveSixTerms {
    double repulsion;
    double attraction;

    PairValue operator()(double distance_squared) const noexcept {
        const double inverse_square = 1.0 / distance_squared;
        const double inverse_sixth = inverse_square * inverse_square * inverse_square;
        const double repulsive = repulsion * inverse_sixth;
        return {inverse_sixth * (repulsive - attraction),
                inverse_square * inverse_sixth * (12.0 * repulsive - 6.0 * attraction)};
    }
};

}  // namespace dlpoly::pair
