// Normal numbers (see normal.hpp).
#include "core/normal.hpp"

#include <cmath>

#include "core/types.hpp"

namespace dlpoly {

double inverse_normal(double p) noexcept {
    constexpr std::array<double, 6> a{-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                                      1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
    constexpr std::array<double, 5> b{-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                                      6.680131188771972e+01, -1.328068155288572e+01};
    constexpr std::array<double, 6> c{-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                                      -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
    constexpr std::array<double, 4> d{7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                                      3.754408661907416e+00};
    constexpr double low = 0.02425;
    const double side = p < 0.5 ? p : 1.0 - p;
    double x = 0.0;  // of the lower half; the distribution is symmetric
    if (side < low) {
        const double q = std::sqrt(-2.0 * std::log(side));
        x = (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
            ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1.0);
    } else {
        const double q = side - 0.5;
        const double r = q * q;
        x = (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
            (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1.0);
    }
    const double error = 0.5 * std::erfc(-x / std::sqrt(2.0)) - side;
    const double step = error * std::sqrt(2.0 * pi) * std::exp(0.5 * x * x);
    x -= step / (1.0 + 0.5 * x * step);
    return p < 0.5 ? x : -x;
}

NormalTable::NormalTable() {
    for (std::uint32_t k = 1; k < pieces; ++k) {
        quantile_[k] = static_cast<float>(inverse_normal(static_cast<double>(k) / pieces));
    }
    // The outermost pieces are computed, never read.
    quantile_[0] = quantile_[1];
    quantile_[pieces] = quantile_[pieces - 1];
}

const NormalTable& normal_table() {
    static const NormalTable table;
    return table;
}

}  // namespace dlpoly
