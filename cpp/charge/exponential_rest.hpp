// e^(−y) Σ_{k ≥ n} yᵏ⁻ⁿ/k!, the rest of the exponential series over yⁿ, without cancellation where y is small.
#pragma once

#include <cmath>

namespace dlpoly::charge {

template <int n>
double exponential_rest(double y) noexcept {
    double first = 1.0;  // 1/n!
    for (int k = 2; k <= n; ++k) {
        first /= k;
    }
    if (y < 2.0) {
        double term = first;
        double sum = term;
        for (int k = n + 1; k <= n + 24; ++k) {
            term *= y / k;
            sum += term;
        }
        return std::exp(-y) * sum;
    }
    double term = 1.0;
    double partial = 1.0;
    for (int k = 1; k < n; ++k) {
        term *= y / k;
        partial += term;
    }
    return (1.0 - std::exp(-y) * partial) / std::pow(y, n);
}

}  // namespace dlpoly::charge
