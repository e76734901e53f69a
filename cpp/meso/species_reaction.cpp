// One reaction between dissolved species (see species_reaction.hpp).
#include "meso/species_reaction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace dlpoly {

namespace {

// t φ(rt) = (exp(rt) − 1)/r, without a product that could overflow where the whole does not.
double grown_time(double rate, double time) { return rate == 0.0 ? time : std::expm1(rate * time) / rate; }

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
        extent = u * grown_time(-p, time);
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
        const double part = grown_time(difference, time);
        if (q > 0.0) {
            extent = v / (1.0 / (u * part) + q);
        } else if (q == 0.0) {
            extent = u * v * part;
        } else {
            // Both terms of D have one sign, and so do those of this sum, which 1 + q u t φ equals.
            extent = u * v * part * difference / (q * u * std::exp(difference * time) - p * v);
        }
        most = p > 0.0 ? u / p : extent;
        most = q > 0.0 ? std::min(most, v / q) : most;
        return std::min(extent, most);
    }
    return p > 0.0 ? std::min(extent, most / p) : extent;
}

}  // namespace dlpoly
