// The electrostatics of a scene (see charge_forces.hpp).
#include "charge/charge_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "charge/bspline.hpp"
#include "charge/registry.hpp"
#include "core/failure.hpp"

namespace dlpoly {

namespace {

// How much finer than that of the forces the grid of energies is: by log2(largest_wide_term / largest_term).
constexpr int wide_bits = 10;
// A pair at this fraction of the cutoff has the force that the grid is chosen for.
constexpr double usual_closeness = 8.0;

void check(const ChargeSettings& settings) {
    if (!(settings.strength > 0.0) || !std::isfinite(settings.strength)) {
        throw std::invalid_argument("the strength of the electrostatics must be larger than 0");
    }
    if (!charge::is_reciprocal(settings.method)) {
        return;
    }
    if (!(settings.numbers.alpha > 0.0)) {
        throw std::invalid_argument("Ewald's sum needs an alpha larger than 0");
    }
    if (settings.order != 0 &&
        (settings.order % 2 != 0 || settings.order < 4 || settings.order > charge::most_splines)) {
        throw std::invalid_argument("the order of the splines must be even, from 4 to " +
                                    std::to_string(charge::most_splines));
    }
    for (const std::int32_t count : settings.counts) {
        if (count < std::max(1, settings.order)) {
            throw std::invalid_argument("a mesh needs at least as many points along each axis as the splines' order");
        }
    }
}

}  // namespace

ChargeForces::ChargeForces(std::span<const double> charges, std::span<const std::uint8_t> frozen,
                           ChargeSettings settings, std::span<const std::pair<std::uint32_t, std::uint32_t>> excluded,
                           std::span<const ScaledPair> scaled)
    : settings_(std::move(settings)) {
    check(settings_);
    if (charges.size() != frozen.size()) {
        throw std::invalid_argument("charges and frozen must describe the same number of beads");
    }
    std::vector<std::uint32_t> place(charges.size(), std::numeric_limits<std::uint32_t>::max());
    const double root = std::sqrt(settings_.strength);
    double largest = 0.0;
    for (std::size_t i = 0; i < charges.size(); ++i) {
        if (!std::isfinite(charges[i])) {
            throw std::invalid_argument("charges must be finite");
        }
        if (charges[i] != 0.0) {
            const double q = root * charges[i];
            place[i] = static_cast<std::uint32_t>(charges_.size());
            charges_.beads.push_back(static_cast<std::uint32_t>(i));
            charges_.charge.push_back(q);
            charges_.frozen.push_back(frozen[i]);
            any_frozen_ = any_frozen_ || frozen[i] != 0;
            largest = std::max(largest, std::abs(q));
            total_ += q;
            total_frozen_ += frozen[i] != 0 ? q : 0.0;
            self_ -= frozen[i] != 0 ? 0.0 : settings_.numbers.alpha / std::sqrt(pi) * q * q;
        }
    }
    const double near = settings_.numbers.cutoff / usual_closeness;
    characteristic_ = std::max(largest * largest / (near * near), std::numeric_limits<double>::min());

    const bool ewald = charge::is_reciprocal(settings_.method);
    kernel_ = charge::make_kernel(settings_.method, settings_.shape, settings_.length, settings_.numbers);
    bare_ = charge::make_kernel(ewald ? "pairwise" : settings_.method, settings_.shape, settings_.length,
                                settings_.numbers);
    const auto known = [&](std::uint32_t i) {
        if (i >= place.size()) {
            throw std::invalid_argument("a pair of charges has a bead that does not exist");
        }
        return place[i];
    };
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::pair<std::uint32_t, std::uint32_t>> left_out;
    std::map<std::pair<std::uint32_t, std::uint32_t>, charge::SpecialPairs::Pair> special;
    for (const auto& [a, b] : excluded) {
        const std::uint32_t i = std::min(known(a), known(b));
        const std::uint32_t j = std::max(known(a), known(b));
        if (j == none || (charges_.frozen[i] != 0 && charges_.frozen[j] != 0)) {
            continue;
        }
        left_out.emplace_back(i, j);
        if (ewald) {
            special[{i, j}] = {i, j, true, 0.0};
        }
    }
    for (const ScaledPair& pair : scaled) {
        const std::uint32_t i = std::min(known(pair.i), known(pair.j));
        const std::uint32_t j = std::max(known(pair.i), known(pair.j));
        if (j != none && !(charges_.frozen[i] != 0 && charges_.frozen[j] != 0)) {
            const auto [found, added] = special.try_emplace({i, j}, charge::SpecialPairs::Pair{i, j, false, 0.0});
            found->second.scale = pair.scale;
        }
    }
    excluded_ = std::make_unique<Exclusions>(charges_.size(), left_out);
    pairs_ = std::make_unique<charge::PairSum>(*kernel_, *excluded_, settings_.numbers.cutoff);
    std::vector<charge::SpecialPairs::Pair> list;
    for (const auto& [ids, pair] : special) {
        list.push_back(pair);
    }
    special_ = std::make_unique<charge::SpecialPairs>(
        charges_.size(), std::move(list),
        ewald ? std::optional(charge::Screening(settings_.numbers.alpha)) : std::nullopt, *bare_,
        ewald ? std::numeric_limits<double>::infinity() : settings_.numbers.cutoff);
    if (ewald) {
        reciprocal_ = settings_.order == 0
                          ? charge::make_plain_sum(settings_.numbers.alpha, settings_.counts)
                          : charge::make_mesh_sum(settings_.numbers.alpha, settings_.counts, settings_.order);
    }
}

Array3N ChargeForces::positions_of(const Particles& particles) const {
    Array3N positions(static_cast<Eigen::Index>(charges_.size()), 3);
    for (std::size_t i = 0; i < charges_.size(); ++i) {
        positions.row(static_cast<Eigen::Index>(i)) =
            particles.position.row(static_cast<Eigen::Index>(charges_.beads[i]));
    }
    return positions;
}

charge::Accumulator ChargeForces::walk(const Box& box, const Array3N& positions, const Vector3& scale,
                                       std::uint64_t step, ChargeTotals* totals) {
    int exponent = wide_bits + grid_exponent(characteristic_ * settings_.numbers.cutoff);
    for (;;) {
        sums_.assign(3 * charges_.size(), 0);
        charge::Accumulator total({scale, std::ldexp(1.0, exponent), totals != nullptr});
        pairs_->add_to(box, positions, charges_, sums_.data(), total);
        if (!special_->empty()) {
            special_->add_to(box, positions, charges_, sums_.data(), total);
        }
        report(total.failure(), step);
        if (total.largest_energy() < 1.0) {
            if (totals != nullptr) {
                totals->energy = total.energy(exponent);
                totals->virial = total.virial(exponent);
            }
            return total;
        }
        exponent -= std::ilogb(total.largest_energy()) + 1;
    }
}

// The interaction of the frozen charges with each other, their images and themselves, as the sum over reciprocal
// vectors has it. Nothing can come of it, and as in DL_POLY it is in no total.
ChargeTotals ChargeForces::frozen_alone(const Box& box, const Array3N& positions) {
    std::vector<double> charges;
    std::vector<Eigen::Index> rows;
    for (std::size_t i = 0; i < charges_.size(); ++i) {
        if (charges_.frozen[i] != 0) {
            charges.push_back(charges_.charge[i]);
            rows.push_back(static_cast<Eigen::Index>(i));
        }
    }
    charge::ReciprocalTotals found;
    const Array3N places = positions(rows, Eigen::all);
    reciprocal_->compute(box, places, charges, nullptr, &found);
    return {found.energy, found.virial};
}

// Of a uniform charge that makes the cell neutral: −πQ²/(2α²V), without what frozen charges have of it alone.
double ChargeForces::background(const Box& box) const {
    const double alpha = settings_.numbers.alpha;
    return -0.5 * pi / (alpha * alpha * box.volume()) * (total_ * total_ - total_frozen_ * total_frozen_);
}

void ChargeForces::add_reciprocal(const Box& box, const Array3N& positions, ChargeTotals* totals) {
    charge::ReciprocalTotals found;
    reciprocal_->compute(box, positions, charges_.charge, &smooth_, totals != nullptr ? &found : nullptr);
    if (totals == nullptr) {
        return;
    }
    const double spread = background(box);
    totals->energy += found.energy + self_ + spread;
    totals->virial += found.virial + spread * Matrix3::Identity();
    if (any_frozen_) {
        const ChargeTotals alone = frozen_alone(box, positions);
        totals->energy -= alone.energy;
        totals->virial -= alone.virial;
    }
}

// Adds the smooth forces to the sums. The mesh lets them add up to nearly zero only; what is left is shared out among
// the charges, as in DL_POLY, here to the last grid unit.
bool ChargeForces::round_reciprocal(const Vector3& scale) {
    const auto count = static_cast<std::int64_t>(charges_.size());
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        std::vector<std::int64_t> rounded(charges_.size());
        std::int64_t rest = 0;
        for (std::int64_t i = 0; i < count; ++i) {
            const double force = smooth_(i, axis) * scale[axis];
            if (!(std::abs(force) < largest_term)) {
                return false;
            }
            rounded[static_cast<std::size_t>(i)] = std::llrint(force);
            rest += rounded[static_cast<std::size_t>(i)];
        }
        const std::int64_t share = any_frozen_ ? 0 : rest / count;
        const std::int64_t more = any_frozen_ ? 0 : rest % count;
        for (std::int64_t i = 0; i < count; ++i) {
            const std::int64_t one = i < std::abs(more) ? (more > 0 ? 1 : -1) : 0;
            sums_[static_cast<std::size_t>(3 * i + axis)] += rounded[static_cast<std::size_t>(i)] - share - one;
        }
    }
    return true;
}

const std::vector<std::int64_t>* ChargeForces::compute(const Box& box, const Array3N& positions, const Vector3& scale,
                                                       std::uint64_t step, ChargeTotals* totals) {
    pairs_->sort(box, positions);
    const charge::Accumulator total = walk(box, positions, scale, step, totals);
    if (!(total.largest() < 1.0)) {
        return nullptr;
    }
    if (reciprocal_ != nullptr && !charges_.charge.empty()) {
        add_reciprocal(box, positions, totals);
        if (!round_reciprocal(scale)) {
            return nullptr;
        }
    }
    return &sums_;
}

void ChargeForces::add_to(const Box& box, Particles& particles, std::uint64_t step, ChargeTotals* totals) {
    const Array3N positions = positions_of(particles);
    pairs_->sort(box, positions);
    int exponent = grid_exponent(characteristic_);
    for (;;) {
        const charge::Accumulator total =
            walk(box, positions, Vector3::Constant(std::ldexp(1.0, exponent)), step, totals);
        if (total.largest() < 1.0) {
            break;
        }
        // Terms beyond the grid's reach are rare (a random start); the choice depends on the largest one alone.
        exponent -= std::ilogb(total.largest()) + 1;
    }
    if (reciprocal_ != nullptr && !charges_.charge.empty()) {
        add_reciprocal(box, positions, totals);
        if (!round_reciprocal(Vector3::Constant(std::ldexp(1.0, exponent)))) {
            throw RunFailure("step " + std::to_string(step) +
                             ": a force of the sum over reciprocal vectors is not finite or out of all proportion");
        }
    }
    const double unit = std::ldexp(1.0, -exponent);
    for (std::size_t i = 0; i < charges_.size(); ++i) {
        if (charges_.frozen[i] == 0) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                particles.force(static_cast<Eigen::Index>(charges_.beads[i]), static_cast<Eigen::Index>(axis)) +=
                    static_cast<double>(sums_[3 * i + axis]) * unit;
            }
        }
    }
}

double ChargeForces::curvature(const Box& box, const Particles& particles) {
    const Array3N positions = positions_of(particles);
    const double cutoff = settings_.numbers.cutoff;
    int exponent = wide_bits + grid_exponent(characteristic_ / cutoff);
    pairs_->sort(box, positions);
    for (;;) {
        charge::Accumulator total({Vector3::Ones(), std::ldexp(1.0, exponent), true});
        pairs_->add_curvature(box, positions, charges_, total);
        special_->add_curvature(box, positions, charges_, total);
        if (total.failure().failed) {
            return std::numeric_limits<double>::quiet_NaN();
        }
        if (total.largest_energy() < 1.0) {
            const double smooth =
                reciprocal_ != nullptr ? reciprocal_->curvature(box, positions, charges_.charge, charges_.frozen) : 0.0;
            return total.energy(exponent) + smooth;
        }
        exponent -= std::ilogb(total.largest_energy()) + 1;
    }
}

void ChargeForces::report(const charge::Failure& failure, std::uint64_t step) const {
    if (!failure.failed) {
        return;
    }
    const std::uint32_t first = charges_.beads[failure.i] + 1;
    const std::uint32_t second = charges_.beads[failure.j] + 1;
    std::ostringstream text;
    text.precision(6);
    text << "step " << step << ": the Coulomb force between beads " << first << " and " << second
         << " is not finite at a distance of " << failure.distance;
    if (!charge::is_soft(settings_.shape)) {
        text << "; point charges that meet need a pair law that keeps them apart, or charge_smearing_method";
    }
    throw RunFailure(text.str());
}

}  // namespace dlpoly
