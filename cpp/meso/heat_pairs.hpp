// What the internal temperatures of two beads do to their drag, noise, repulsion and exchange of heat: the coefficients
// of energy-conserving DPD. Li, Tang, Lei, Caswell and Karniadakis, J. Comput. Phys. 265, 113 (2014).
//
// Temperatures are k_B T and heat capacities C_v/k_B, so that the internal energy of a bead is their product. T̄ is the
// mean of a pair and x = T̄/T_ref − 1; a polynomial is 1 + c₁x + c₂x² + c₃x³ + c₄x⁴.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace dlpoly {

// Coefficients of two species.
struct HeatPair {
    using Polynomial = std::array<double, 4>;

    double conductivity = 0.0;  // κ₀, 1/ps
    double range = 0.0;         // r_cT, Å
    double exponent = 2.0;      // s_T of w_T² = (1 − r/r_cT)^s_T
    Polynomial weight{};        // of the exponent s of w^D
    Polynomial conduction{};    // of κ
    Polynomial drag{};          // of γ
};

class HeatPairs {
  public:
    // `reference` is k_B T_ref, `weight_exponent` s at T_ref; all terms begin without conduction.
    HeatPairs(std::int32_t species, double reference, double weight_exponent)
        : reference_(reference),
          inverse_reference_(1.0 / reference),
          weight_exponent_(weight_exponent),
          species_(species) {
        pairs_.resize(static_cast<std::size_t>(species) * static_cast<std::size_t>(species));
    }

    void set(std::int32_t a, std::int32_t b, const HeatPair& pair) {
        pairs_[static_cast<std::size_t>(a * species_ + b)] = pair;
        pairs_[static_cast<std::size_t>(b * species_ + a)] = pair;
    }

    [[nodiscard]] const HeatPair& at(std::uint32_t term) const noexcept { return pairs_[term]; }
    [[nodiscard]] const std::vector<HeatPair>& all() const noexcept { return pairs_; }
    [[nodiscard]] double reference() const noexcept { return reference_; }
    [[nodiscard]] double weight_exponent() const noexcept { return weight_exponent_; }

    [[nodiscard]] static double value(const HeatPair::Polynomial& c, double x) noexcept {
        return 1.0 + x * (c[0] + x * (c[1] + x * (c[2] + x * c[3])));
    }
    [[nodiscard]] static double slope(const HeatPair::Polynomial& c, double x) noexcept {
        return c[0] + x * (2.0 * c[1] + x * (3.0 * c[2] + x * 4.0 * c[3]));
    }

    // σ² = 4γ T_i T_j/(T_i + T_j) = 2γ times this: twice the reduced temperature of the two.
    [[nodiscard]] static double thermal_energy(double a, double b) noexcept {
        const double low = std::min(a, b);  // the same bits whichever of the two comes first
        return 2.0 * low / (low / std::max(a, b) + 1.0);
    }

    // γ of a pair over γ at T_ref.
    [[nodiscard]] double drag_factor(std::uint32_t term, double mean) const noexcept {
        return std::max(0.0, value(pairs_[term].drag, mean * inverse_reference_ - 1.0));
    }

    // s of w^D = (1 − r/r_c)^s.
    static constexpr double least_weight_exponent = 0.01;
    [[nodiscard]] double weight_exponent(std::uint32_t term, double mean) const noexcept {
        const double x = mean * inverse_reference_ - 1.0;
        return std::max(least_weight_exponent, weight_exponent_ * value(pairs_[term].weight, x));
    }
    [[nodiscard]] bool weight_varies(std::uint32_t term) const noexcept { return pairs_[term].weight != none; }
    [[nodiscard]] bool drag_varies(std::uint32_t term) const noexcept { return pairs_[term].drag != none; }

    // What heat capacities add to the drag of two beads, relative to it: ½ (∂/∂ε_a + ∂/∂ε_b)(γ w^D T_r)/(γ w^D) with
    // T_r of thermal_energy(), because an impulse also changes the temperatures that its noise depends on. Of order
    // 1/C. `log_slope` is that of γ w^D, per T̄.
    [[nodiscard]] static double drag_of_noise(double a, double b, double inverse_capacity_a, double inverse_capacity_b,
                                              double log_slope) noexcept {
        constexpr double least = -0.5, most = 1.0;  // it is the first term of a series
        const double low = std::min(a, b);          // the same bits whichever of the two comes first
        const double ratio = low / std::max(a, b);
        const double of_low = 1.0 / (ratio + 1.0);
        const double of_high = ratio * of_low;
        const double of_a = a == low ? of_low : of_high;
        const double of_b = b == low ? of_low : of_high;
        const double sum = 2.0 * (inverse_capacity_a * of_a * of_a + inverse_capacity_b * of_b * of_b) +
                           (inverse_capacity_a + inverse_capacity_b) * low * of_low * log_slope;
        return std::isfinite(sum) ? std::clamp(0.5 * sum, least, most) : 0.0;
    }
    // The slope of ln(γ w^D) at a pair's mean temperature, of its weight and of its drag; ln(1 − r/r_c) is given.
    [[nodiscard]] double log_slope(std::uint32_t term, double mean, double log_closeness) const noexcept {
        const HeatPair& pair = pairs_[term];
        const double x = mean * inverse_reference_ - 1.0;
        double sum = weight_exponent_ * slope(pair.weight, x) * log_closeness;
        if (drag_varies(term)) {
            sum += slope(pair.drag, x) / value(pair.drag, x);
        }
        return sum * inverse_reference_;
    }

    std::vector<std::uint8_t> held;  // by id: the temperature of these beads stays what it is
    bool scaled_repulsion = false;   // conservative pair forces times T̄/T_ref

  private:
    static constexpr HeatPair::Polynomial none{};

    std::vector<HeatPair> pairs_;  // by term
    double reference_;
    double inverse_reference_;
    double weight_exponent_;
    std::int32_t species_;
};

}  // namespace dlpoly
