// Bonded terms and electrostatics on the fast path (see added_forces.hpp).
#include "fast/added_forces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dlpoly::fast {

template <class Record>
void AddedForces<Record>::set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species) {
    bonded_ = &terms;
    bonded_totals_ = &totals;
    species_ = std::move(species);
    make_room(terms.bead_end());
}

template <class Record>
void AddedForces<Record>::set_charges(ChargeForces& charges, ChargeTotals& totals) {
    charges_ = &charges;
    charge_totals_ = &totals;
    make_room(charges.charges().beads.back() + 1);
}

template <class Record>
void AddedForces<Record>::make_room(std::uint32_t end) {
    end_ = std::max(end_, end);
    positions_.assign(3 * std::size_t{end_}, 0.0);
    impulses_.assign(3 * std::size_t{end_}, 0);
}

template <class Record>
void AddedForces<Record>::restart(int threads) {
    workers_.assign(static_cast<std::size_t>(threads) + 1, bonded::Worker(request(false, 0), impulses_.data()));
}

template <class Record>
void AddedForces<Record>::prepare(std::size_t parts) {
    if (bonded_ != nullptr) {
#ifdef _OPENMP
#pragma omp single
#endif
        bonded_->prepare(parts);
    }
}

template <class Record>
void AddedForces<Record>::describe(PassArguments<Record>& a) {
    a.bonded = end_ > 0 ? impulses_.data() : nullptr;
    a.bonded_end = end_;
}

template <class Record>
bool AddedForces<Record>::compute(const State& state, std::size_t part, std::size_t parts, std::uint64_t step,
                                  bool observe) {
    return (bonded_ == nullptr || add_bonded(state, part, parts, observe)) &&
           (charges_ == nullptr || add_charges(state, step, observe));
}

// Forces are rounded straight to impulses, so that they conserve momentum to the bit as pairs do.
template <class Record>
bonded::Request AddedForces<Record>::request(bool observe, int energy_exponent) const {
    bonded::Request made;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        made.scale[axis] = timestep_ / units_.momentum_along(axis);
    }
    made.energy_scale = std::ldexp(1.0, energy_exponent);
    made.observe = observe;
    return made;
}

template <class Record>
bool AddedForces<Record>::add_bonded(const State& state, std::size_t part, std::size_t parts, bool observe) {
    const bonded::MinimumImage image(state.box);
    const auto walk = [&](std::size_t p) {
        workers_[p] = bonded::Worker(request(observe, bonded_->energy_exponent()), impulses_.data());
        bonded_->part(p, image, positions_.data(), species_, table_, workers_[p]);
    };
    walk(part);
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    walk(parts);  // one part a thread, and after them the terms that cross their borders
    return std::none_of(workers_.begin(), workers_.end(),
                        [](const bonded::Worker& worker) { return worker.failure().law != nullptr; });
}

// One thread computes them: the charges are few among the beads.
template <class Record>
bool AddedForces<Record>::add_charges(const State& state, std::uint64_t step, bool observe) {
#ifdef _OPENMP
#pragma omp barrier
#pragma omp single
#endif
    try {
        const std::vector<std::uint32_t>& beads = charges_->charges().beads;
        Array3N positions(static_cast<Eigen::Index>(beads.size()), 3);
        for (std::size_t i = 0; i < beads.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                positions(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) =
                    positions_[3 * std::size_t{beads[i]} + axis];
            }
        }
        const std::vector<std::int64_t>* impulses =
            charges_->compute(state.box, positions, request(false, 0).scale, step, observe ? charge_totals_ : nullptr);
        charges_stop_ = impulses == nullptr;
        for (std::size_t i = 0; impulses != nullptr && i < beads.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                impulses_[3 * std::size_t{beads[i]} + axis] += (*impulses)[3 * i + axis];
            }
        }
    } catch (...) {
        charge_failure_ = std::current_exception();
        charges_stop_ = true;
    }
    return !charges_stop_;
}

template <class Record>
bool AddedForces<Record>::finish(const State& state, std::size_t parts, std::uint64_t step) {
    if (bonded_ != nullptr) {
        BondedForces::report(workers_, bonded::MinimumImage(state.box), step);
        observe_bonded(state, parts);
    }
    if (charge_failure_) {
        std::fill(impulses_.begin(), impulses_.end(), 0);
        std::rethrow_exception(std::exchange(charge_failure_, nullptr));
    }
    return charges_stop_ || std::any_of(workers_.begin(), workers_.end(),
                                        [](const bonded::Worker& worker) { return worker.largest() >= 1.0; });
}

// Totals of the observed step. Energies beyond their grid are rare (a random start): they are then added up once more
// on a coarser one, as on the general path.
template <class Record>
void AddedForces<Record>::observe_bonded(const State& state, std::size_t parts) {
    const bonded::MinimumImage image(state.box);
    int exponent = bonded_->energy_exponent();
    std::vector<std::int64_t> unused;
    for (;;) {
        double largest = 0.0;
        for (const bonded::Worker& worker : workers_) {
            largest = std::max(largest, worker.largest_energy());
        }
        if (largest < 1.0) {
            *bonded_totals_ = BondedForces::total(workers_, exponent);
            return;
        }
        exponent -= std::ilogb(largest) + 1;
        unused.assign(impulses_.size(), 0);
        for (std::size_t p = 0; p <= parts; ++p) {
            workers_[p] = bonded::Worker(request(true, exponent), unused.data());
            bonded_->part(p, image, positions_.data(), species_, table_, workers_[p]);
        }
    }
}

template class AddedForces<MixedRecord>;
template class AddedForces<DoubleRecord>;

}  // namespace dlpoly::fast
