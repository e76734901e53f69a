// Long-range corrections: what a pair law would add beyond the cutoff in a uniform fluid.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pair/law.hpp"

namespace dlpoly::pair {

// energy = ∫ U r² dr and virial = ∫ r³ (dU/dr) dr from the cutoff to infinity. The system's energy gains
// (2π/V) N_a N_b · energy (twice that for a ≠ b) and its Σ r dU/dr the same with virial.
struct Tail {
    double energy = 0.0;
    double virial = 0.0;
};

namespace detail {

// Positive nodes and weights of the 16-point Gauss–Legendre rule on [−1, 1].
inline constexpr std::array<double, 8> gauss_nodes{0.0950125098376374402, 0.2816035507792589132, 0.4580167776572273863,
                                                   0.6178762444026437484, 0.7554044083550030339, 0.8656312023878317439,
                                                   0.9445750230732325761, 0.9894009349916499326};
inline constexpr std::array<double, 8> gauss_weights{
    0.1894506104550684963, 0.1826034150449235889, 0.1691565193950025382, 0.1495959888165767321,
    0.1246289712555338720, 0.0951585116824927848, 0.0622535239386478929, 0.0271524594117540949};

template <class Function>
Tail gauss(const Function& integrand, double from, double to) {
    const double middle = 0.5 * (from + to);
    const double half = 0.5 * (to - from);
    Tail sum;
    for (std::size_t k = 0; k < gauss_nodes.size(); ++k) {
        for (const double sign : {-1.0, 1.0}) {
            const Tail value = integrand(middle + sign * half * gauss_nodes[k]);
            sum.energy += half * gauss_weights[k] * value.energy;
            sum.virial += half * gauss_weights[k] * value.virial;
        }
    }
    return sum;
}

// Halves a panel until its two halves agree with the whole to `tolerance` of themselves or of `scale`, the size of
// what has been added so far.
template <class Function>
Tail adaptive(const Function& integrand, double from, double to, const Tail& scale, int depth) {
    constexpr double tolerance = 1e-13;
    const double middle = 0.5 * (from + to);
    const Tail whole = gauss(integrand, from, to);
    const Tail left = gauss(integrand, from, middle);
    const Tail right = gauss(integrand, middle, to);
    const Tail sum{left.energy + right.energy, left.virial + right.virial};
    const auto agrees = [&](double a, double b, double size) {
        return std::abs(a - b) <= tolerance * std::max(std::abs(a) + std::abs(b), size);
    };
    if (depth == 0 ||
        (agrees(whole.energy, sum.energy, scale.energy) && agrees(whole.virial, sum.virial, scale.virial))) {
        return sum;
    }
    const Tail first = adaptive(integrand, from, middle, scale, depth - 1);
    const Tail second = adaptive(integrand, middle, to, scale, depth - 1);
    return {first.energy + second.energy, first.virial + second.virial};
}

}  // namespace detail

// The integrals of the law itself. With r = rc/t the range is t in (0, 1]; panels halve towards t = 0, so that any tail
// that falls faster than r⁻³ ends after some tens of them. A slower one throws std::invalid_argument.
template <class Law>
Tail integrated_tail(const Law& law, double cutoff) {
    const auto integrand = [&](double t) -> Tail {
        const double distance = cutoff / t;
        const PairValue value = law(distance * distance);
        const double measure = distance * distance * distance / t;  // r² |dr/dt|
        return {value.energy * measure, -(value.force_over_r * distance * distance) * measure};
    };
    Tail sum;
    Tail size;  // of the absolute values: the scale for "small", also when the sum cancels
    constexpr int panels = 200;
    double to = 1.0;
    for (int panel = 0; panel < panels; ++panel, to *= 0.5) {
        const Tail part = detail::adaptive(integrand, 0.5 * to, to, size, 12);
        if (!std::isfinite(part.energy) || !std::isfinite(part.virial)) break;
        sum.energy += part.energy;
        sum.virial += part.virial;
        size.energy += std::abs(part.energy);
        size.virial += std::abs(part.virial);
        constexpr double negligible = 1e-13;
        if (std::abs(part.energy) <= negligible * size.energy && std::abs(part.virial) <= negligible * size.virial) {
            return sum;
        }
    }
    throw std::invalid_argument("pair law " + std::string(Law::info.key) +
                                ": the long-range correction is infinite, because U falls off like r^-3 or slower");
}

// A law's own correction where it has one, none where DL_POLY has none, else the integral.
template <class Law>
Tail tail(const Law& law, double cutoff) {
    if constexpr (!Law::info.has_tail) {
        return {};
    } else if constexpr (requires { law.tail(cutoff); }) {
        return law.tail(cutoff);
    } else {
        return integrated_tail(law, cutoff);
    }
}

}  // namespace dlpoly::pair
