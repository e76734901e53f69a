// What one thread keeps while it walks bonded terms: exact partial sums and the first term that failed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "bonded/law.hpp"
#include "core/exact_sum.hpp"
#include "core/types.hpp"

namespace dlpoly::bonded {

// Is shown every term instead of its energy and virial being added: its beads, the forces on all of them but the last
// (whose force is minus their sum) and the arms from the last bead to the others. A tether has one bead, one force and
// the arm from its anchor.
class TermVisitor {
  public:
    TermVisitor() = default;
    TermVisitor(const TermVisitor&) = delete;
    TermVisitor& operator=(const TermVisitor&) = delete;
    TermVisitor(TermVisitor&&) = delete;
    TermVisitor& operator=(TermVisitor&&) = delete;
    virtual ~TermVisitor() = default;

    virtual void visit(std::size_t component, std::span<const std::uint32_t> beads, std::span<const Vector3> forces,
                       std::span<const Vector3> arms) = 0;
};

// What one walk over the terms is asked for.
struct Request {
    Vector3 scale = Vector3::Ones();  // grid units per force along each axis: a force is rounded once, times this
    double energy_scale = 0.0;        // grid units per energy
    bool observe = false;             // also energies and virials
    TermVisitor* visitor = nullptr;   // with observe: is shown the terms
};

// Energies and virials are added in 128 bits: their terms may be this large.
inline constexpr double largest_wide_term = 0x1p61;

// The terms' kinds, and after them the pairs with a scaled pair law.
inline constexpr std::size_t components = kinds + 1;
inline constexpr std::size_t scaled_pairs = kinds;

// A term that cannot be computed.
struct Failure {
    const LawInfo* law = nullptr;  // nullptr: none
    bool too_long = false;
    double length = 0.0;
    std::array<std::uint32_t, 4> beads{};

    // Of several the one with the smallest bead numbers is reported, whatever thread met it.
    [[nodiscard]] bool before(const Failure& other) const noexcept {
        return law != nullptr && (other.law == nullptr || beads < other.beads);
    }
};

class Worker {
  public:
    Worker(const Request& request, std::int64_t* sums) : request_(request), sums_(sums) {}

    // Adds one term: forces on all its beads but the last, which gets exactly minus their sum (but for a tether, which
    // has one bead), and the arms from the last bead to the others. Returns false when a force or the energy is not
    // finite.
    template <std::size_t Beads>
    bool add(std::size_t component, const std::array<std::uint32_t, Beads>& beads, double energy,
             const std::array<Vector3, std::max<std::size_t>(Beads, 2) - 1>& forces,
             const std::array<Vector3, std::max<std::size_t>(Beads, 2) - 1>& arms) {
        constexpr std::size_t count = std::max<std::size_t>(Beads, 2) - 1;
        double largest = 0.0;
        bool finite = std::isfinite(energy);
        for (const Vector3& force : forces) {
            finite = finite && force.allFinite();
            largest = std::max(largest, force.cwiseProduct(request_.scale).cwiseAbs().maxCoeff());
        }
        if (!finite) {
            return false;
        }
        // The last bead's sum may be this much larger.
        largest *= static_cast<double>(count);
        largest_ = std::max(largest_, largest / largest_term);
        if (request_.observe) {
            if (request_.visitor != nullptr) {
                request_.visitor->visit(component, beads, forces, arms);
                return true;
            }
            observe(component, energy, forces, arms);
        }
        if (largest >= largest_term) {
            return true;  // this walk is repeated on a coarser grid
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::int64_t rest = 0;
            for (std::size_t k = 0; k < count; ++k) {
                const auto a = static_cast<Eigen::Index>(axis);
                const std::int64_t rounded = std::llrint(forces[k][a] * request_.scale[a]);
                sums_[3 * std::size_t{beads[k]} + axis] += rounded;
                rest -= rounded;
            }
            if constexpr (Beads > 1) {
                sums_[3 * std::size_t{beads[Beads - 1]} + axis] += rest;
            }
        }
        return true;
    }

    void fail(const Failure& failure) {
        if (failure.before(failure_)) {
            failure_ = failure;
        }
    }

    [[nodiscard]] const Failure& failure() const noexcept { return failure_; }
    // In units of the largest term that the grids allow.
    [[nodiscard]] double largest() const noexcept { return largest_; }
    [[nodiscard]] double largest_energy() const noexcept { return largest_energy_; }
    [[nodiscard]] const WideSum& energy(std::size_t component) const noexcept { return energy_[component]; }
    [[nodiscard]] const WideSum& virial(std::size_t component, std::size_t k) const noexcept {
        return virial_[component][k];
    }
    [[nodiscard]] const Request& request() const noexcept { return request_; }

  private:
    template <std::size_t Count>
    void observe(std::size_t component, double energy, const std::array<Vector3, Count>& forces,
                 const std::array<Vector3, Count>& arms) {
        Matrix3 virial = Matrix3::Zero();
        for (std::size_t k = 0; k < Count; ++k) {
            virial += forces[k] * arms[k].transpose();
        }
        virial *= request_.energy_scale;
        const double scaled = energy * request_.energy_scale;
        const double largest = std::max(std::abs(scaled), virial.cwiseAbs().maxCoeff());
        largest_energy_ = std::max(largest_energy_, largest / largest_wide_term);
        if (!(largest < largest_wide_term)) {
            return;
        }
        energy_[component].add(std::llrint(scaled));
        for (std::size_t k = 0; k < 9; ++k) {
            virial_[component][k].add(
                std::llrint(virial(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3))));
        }
    }

    Request request_;
    std::int64_t* sums_;
    std::array<WideSum, components> energy_{};
    std::array<std::array<WideSum, 9>, components> virial_{};
    double largest_ = 0.0;
    double largest_energy_ = 0.0;
    Failure failure_;
};

}  // namespace dlpoly::bonded
