// One reaction between dissolved species (see species_reaction.hpp).
#include "meso/species_reaction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace dlpoly {

namespace {

// (exp(x) − 1)/x.
double growth(double x) { return x == 0.0 ? 1.0 : std::expm1(x) / x; }

}  // namespace

SpeciesReaction::SpeciesReaction(double rate, std::vector<std::int32_t> reactants, std::vector<double> change,
                                 std::int32_t bead_species)
    : rate_(rate), change_(std::move(change)), where_(bead_species) {
    if (reactants.empty() || reactants.size() > 2) {
        throw std::invalid_argument("a reaction needs one or two reactants");
    }
    for (const std::int32_t species : reactants) {
        if (species < 0 || static_cast<std::size_t>(species) >= change_.size()) {
            throw std::invalid_argument("a reactant is no dissolved species");
        }
    }
    first_ = static_cast<std::size_t>(reactants.front());
    second_ = static_cast<std::size_t>(reactants.back());
    second_order_ = reactants.size() == 2;
    if (second_order_ && change_[first_] > 0.0 && change_[second_] > 0.0) {
        throw std::invalid_argument("a reaction of second order that makes more of both reactants has no bound");
    }
}

double SpeciesReaction::extent(const double* amounts, double duration) const {
    double u = amounts[first_];
    double p = -change_[first_];
    const double time = rate_ * duration;
    double most = u;  // of what the reaction can take, over p
    double extent = 0.0;
    if (!second_order_) {
        extent = u * time * growth(-p * time);
    } else {
        double v = amounts[second_];
        double q = -change_[second_];
        if (u == 0.0 || v == 0.0) {
            return 0.0;
        }
        double difference = first_ == second_ ? 0.0 : q * u - p * v;
        if (difference > 0.0) {  // the names of the two are exchanged, so that exp(kDt) is at most 1
            std::swap(u, v);
            std::swap(p, q);
            difference = -difference;
        }
        const double part = time * growth(difference * time);
        // Where one of the two grows, both terms of D have one sign; the other form would lose all digits.
        const double remains =
            q < 0.0 ? (q * u * std::exp(difference * time) - p * v) / difference : 1.0 + q * u * part;
        extent = u * v * part / remains;
        most = p > 0.0 ? u / p : extent;
        most = q > 0.0 ? std::min(most, v / q) : most;
        return std::min(extent, most);
    }
    return p > 0.0 ? std::min(extent, most / p) : extent;
}

}  // namespace dlpoly
