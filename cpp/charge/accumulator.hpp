// What one thread keeps while it walks pairs of charges: exact partial sums, and the first pair that failed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/exact_sum.hpp"
#include "core/types.hpp"

namespace dlpoly::charge {

// What one evaluation is asked for.
struct Request {
    Vector3 scale = Vector3::Ones();  // grid units per force along each axis: a force is rounded once, times this
    double energy_scale = 0.0;        // grid units per energy
    bool observe = false;             // also energies and virials
};

// Energies and virials are added in 128 bits: their terms may be this large.
inline constexpr double largest_wide_term = 0x1p61;

// A pair that cannot be computed, by the places of its charges in the list of charged beads.
struct Failure {
    bool failed = false;
    double distance = 0.0;
    std::uint32_t i = 0, j = 0;

    // Of several the one with the smallest numbers is reported, whatever thread met it.
    [[nodiscard]] bool before(const Failure& other) const noexcept {
        return failed && (!other.failed || i < other.i || (i == other.i && j < other.j));
    }
};

class Accumulator {
  public:
    explicit Accumulator(const Request& request) : request_(request) {}

    // Adds a force to what acts on i and, where given, its opposite to j. The walk is repeated on a coarser grid when a
    // term is too large; the sums then mean nothing.
    void add_force(const Vector3& force, std::int64_t* on_i, std::int64_t* on_j) noexcept {
        const Vector3 scaled = force.cwiseProduct(request_.scale);
        const double largest = scaled.cwiseAbs().maxCoeff();
        largest_ = std::max(largest_, largest / largest_term);
        if (!(largest < largest_term)) {
            return;
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t rounded = std::llrint(scaled[static_cast<Eigen::Index>(axis)]);
            on_i[axis] += rounded;
            if (on_j != nullptr) {
                on_j[axis] -= rounded;
            }
        }
    }

    // Adds a pair's energy and its virial factor·d dᵀ.
    void add_energy(double energy, double factor, const Vector3& d) noexcept {
        const double scaled = energy * request_.energy_scale;
        const Vector3 half = (factor * request_.energy_scale) * d;
        const double largest = std::max(std::abs(scaled), std::abs(half.dot(d)));
        largest_energy_ = std::max(largest_energy_, largest / largest_wide_term);
        if (!(largest < largest_wide_term)) {
            return;
        }
        energy_.add(std::llrint(scaled));
        std::size_t k = 0;
        for (Eigen::Index a = 0; a < 3; ++a) {
            for (Eigen::Index b = a; b < 3; ++b) {
                virial_[k++].add(std::llrint(half[a] * d[b]));
            }
        }
    }

    void fail(std::uint32_t i, std::uint32_t j, double distance) noexcept {
        const Failure failure{true, distance, std::min(i, j), std::max(i, j)};
        if (failure.before(failure_)) {
            failure_ = failure;
        }
    }

    void add(const Accumulator& other) noexcept {
        energy_.add(other.energy_);
        for (std::size_t k = 0; k < virial_.size(); ++k) {
            virial_[k].add(other.virial_[k]);
        }
        largest_ = std::max(largest_, other.largest_);
        largest_energy_ = std::max(largest_energy_, other.largest_energy_);
        if (other.failure_.before(failure_)) {
            failure_ = other.failure_;
        }
    }

    [[nodiscard]] double energy(int exponent) const noexcept { return energy_.value(exponent); }
    [[nodiscard]] Matrix3 virial(int exponent) const noexcept {
        Matrix3 tensor;
        std::size_t k = 0;
        for (Eigen::Index a = 0; a < 3; ++a) {
            for (Eigen::Index b = a; b < 3; ++b) {
                tensor(a, b) = tensor(b, a) = virial_[k++].value(exponent);
            }
        }
        return tensor;
    }
    [[nodiscard]] const Request& request() const noexcept { return request_; }
    [[nodiscard]] const Failure& failure() const noexcept { return failure_; }
    // In units of the largest term that the grids allow.
    [[nodiscard]] double largest() const noexcept { return largest_; }
    [[nodiscard]] double largest_energy() const noexcept { return largest_energy_; }

  private:
    Request request_;
    WideSum energy_;
    std::array<WideSum, 6> virial_{};
    double largest_ = 0.0;
    double largest_energy_ = 0.0;
    Failure failure_;
};

}  // namespace dlpoly::charge
