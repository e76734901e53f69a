// Pair law 14-7: the buffered potential of Halgren (AMOEBA).
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/tail.hpp"

namespace dlpoly::pair {

class FourteenSeven {
    static constexpr std::array<std::string_view, 2> names{"eps", "r0"};

  public:
    static constexpr LawInfo info{
        .key = "14-7",
        .description = "buffered 14-7 (AMOEBA), eps [1.07/(q+0.07)]^7 [1.12/(q^7+0.12) - 2], q = r/r0",
        .parameter_names = names,
        .energy_mask = 0b01,
        .drag_slot = 3,
        .soft = true,
        .has_tail = true,
        .mixable = true,
        .shiftable = true};

    FourteenSeven(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        depth_ = given.any(0);
        inverse_minimum_ = 1.0 / given.positive(1);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double q = distance * inverse_minimum_;
        const double q_sixth = sixth_power(q);
        const double inverse_sum = 1.0 / (q + 0.07);
        const double buffer = 1.07 * inverse_sum;
        const double outer = depth_ * sixth_power(buffer) * buffer;
        const double inverse_inner = 1.0 / (q_sixth * q + 0.12);
        const double inner = 1.12 * inverse_inner;
        const double slope = (inner - 2.0) * inverse_sum + inner * inverse_inner * q_sixth;  // −dU/dq = 7 outer slope
        return {outer * (inner - 2.0), 7.0 * outer * slope * inverse_minimum_ * inverse_or_zero(distance)};
    }

    // DL_POLY's own correction, so that energies and pressures agree with its files. It is not quite the integral (3e-5
    // of the energy, 2e-3 of the virial off): Simpson's rule runs in 60 blocks of 5000 panels, the first panel of every
    // next block counts twice, and the derivative of 1.12/(q⁷ + 0.12) is added, without eps, where it should be
    // subtracted with it.
    Tail tail(double cutoff) const noexcept {
        constexpr int blocks = 60;
        constexpr int panels = 5001;
        const double start = cutoff * inverse_minimum_;
        const double half_panel = start / 10000.0;
        const auto integrand = [this](double q) {
            const double inverse_sum = 1.0 / (q + 0.07);
            const double buffer = 1.07 * inverse_sum;
            const double outer = sixth_power(buffer) * buffer;
            const double inverse_inner = 1.0 / (sixth_power(q) * q + 0.12);
            const double inner = 1.12 * inverse_inner;
            const double energy = depth_ * outer * (inner - 2.0);
            const double slope = -7.0 * (energy * inverse_sum - outer * inner * inverse_inner * sixth_power(q));
            return Tail{q * q * energy, q * q * q * slope};
        };
        Tail sum;
        for (int block = 0; block < blocks; ++block) {
            const double first = start * (1 + block);
            for (int point = 0; point <= 2 * panels; ++point) {
                const double weight = point == 0 || point == 2 * panels ? 1.0 : point % 2 == 1 ? 4.0 : 2.0;
                const Tail value = integrand(first + half_panel * point);
                sum.energy += weight * value.energy;
                sum.virial += weight * value.virial;
            }
        }
        const double factor = half_panel / (3.0 * inverse_minimum_ * inverse_minimum_ * inverse_minimum_);
        return {factor * sum.energy, factor * sum.virial};
    }

  private:
    double depth_, inverse_minimum_;
};

}  // namespace dlpoly::pair
