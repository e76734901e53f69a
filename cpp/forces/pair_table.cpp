// The pair table (see pair_table.hpp).
#include "forces/pair_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "forces/pair_phases.hpp"

namespace dlpoly {

namespace {

constexpr std::uint32_t no_kernel = std::numeric_limits<std::uint32_t>::max();

}  // namespace

PairTable::PairTable(std::int32_t species)
    : species_(species),
      terms_(static_cast<std::size_t>(species) * static_cast<std::size_t>(species)),
      law_cutoff_(terms_, 0.0),
      reach_squared_(terms_, 0.0),
      kernel_of_(terms_, no_kernel),
      drags_(terms_),
      soft_laws_(terms_) {
    static_cast<void>(chosen_phases());  // an instruction set that cannot be had is no fault of any pair: said first
}

std::uint32_t PairTable::kernel_index(const std::string& key) {
    const auto found = std::find(keys_.begin(), keys_.end(), key);
    if (found == keys_.end()) {
        kernels_.push_back(make_kernel(key, terms_));
        keys_.push_back(key);
        return static_cast<std::uint32_t>(keys_.size() - 1);
    }
    return static_cast<std::uint32_t>(found - keys_.begin());
}

void PairTable::set_reach(std::int32_t a, std::int32_t b, double cutoff) {
    for (const std::uint32_t t : {term(a, b), term(b, a)}) {
        reach_squared_[t] = std::max(reach_squared_[t], cutoff * cutoff);
    }
    range_ = std::max(range_, cutoff);
}

void PairTable::set_law(std::int32_t a, std::int32_t b, const std::string& key, std::span<const double> parameters,
                        double cutoff, bool force_shift) {
    if (!(cutoff > 0.0) || !std::isfinite(cutoff)) {
        throw std::invalid_argument("a pair law needs a cutoff larger than 0");
    }
    const std::uint32_t kernel = kernel_index(key);
    for (const std::uint32_t t : {term(a, b), term(b, a)}) {
        kernels_[kernel]->add(t, parameters, cutoff, force_shift);
        kernel_of_[t] = kernel;
        law_cutoff_[t] = cutoff;
        if (key == "dpd" && parameters[1] == cutoff) {
            soft_laws_[t] = {parameters[0], cutoff};
        } else {
            only_soft_ = false;
        }
    }
    set_reach(a, b, cutoff);
}

void PairTable::set_table(std::int32_t a, std::int32_t b, std::span<const double> energy,
                          std::span<const double> virial, double spacing, double cutoff, bool force_shift) {
    const std::uint32_t kernel = kernel_index("tab");
    only_soft_ = false;
    for (const std::uint32_t t : {term(a, b), term(b, a)}) {
        kernels_[kernel]->add_table(t, energy, virial, spacing, cutoff, force_shift);
        kernel_of_[t] = kernel;
        law_cutoff_[t] = cutoff;
    }
    set_reach(a, b, cutoff);
}

bool PairTable::is_soft() const noexcept {
    for (std::size_t t = 0; t < terms_; ++t) {
        if (drags_[t].drag > 0.0 && soft_laws_[t].cutoff > 0.0 && drags_[t].cutoff != soft_laws_[t].cutoff) {
            return false;
        }
    }
    return only_soft_;
}

void PairTable::set_drag(std::int32_t a, std::int32_t b, const PairDrag& drag) {
    drags_[term(a, b)] = drag;
    drags_[term(b, a)] = drag;
    if (drag.drag > 0.0) {
        has_drag_ = true;
        set_reach(a, b, drag.cutoff);
    }
}

double PairTable::characteristic_force(double thermal_energy) const {
    constexpr int points = 400;
    double largest = 0.0;
    for (std::uint32_t t = 0; t < terms_; ++t) {
        if (kernel_of_[t] == no_kernel) {
            continue;
        }
        const PairKernel& law = *kernels_[kernel_of_[t]];
        const double cutoff = law_cutoff_[t];
        const double reference = law.at(t, cutoff * (1.0 - 1e-12)).first;
        std::vector<double> forces;
        for (int k = points - 1; k > 0; --k) {
            const auto [energy, force] = law.at(t, cutoff * k / points);
            // Both directions count: Buckingham's law falls without bound inside its barrier.
            if (!std::isfinite(energy) || !std::isfinite(force) ||
                (thermal_energy > 0.0 && std::abs(energy - reference) > 50.0 * thermal_energy)) {
                break;
            }
            forces.push_back(std::abs(force));
        }
        if (forces.empty()) {
            continue;
        }
        if (thermal_energy > 0.0) {
            largest = std::max(largest, *std::max_element(forces.begin(), forces.end()));
        } else {
            // Without a temperature nothing says how close beads come: a multiple of the law's middle force.
            const auto middle = forces.begin() + static_cast<std::ptrdiff_t>(forces.size() / 2);
            std::nth_element(forces.begin(), middle, forces.end());
            largest = std::max(largest, 64.0 * *middle);
        }
    }
    return largest;
}

}  // namespace dlpoly
