// Cardinal B-splines M_p and their slopes (Essmann and others, J. Chem. Phys. 103, 8577 (1995)).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace dlpoly::charge {

inline constexpr int most_splines = 20;

// M_p(f + j) and M_p'(f + j), j = 0 … p − 1, for 0 ≤ f < 1 and p ≥ 2.
struct BSpline {
    std::array<double, most_splines> value{};
    std::array<double, most_splines> slope{};

    BSpline(double f, int order) noexcept {
        value[0] = f;
        value[1] = 1.0 - f;
        for (int n = 3; n <= order; ++n) {
            if (n == order) {
                for (int j = 0; j < order; ++j) {
                    slope[at(j)] = value[at(j)] - (j > 0 ? value[at(j - 1)] : 0.0);
                }
            }
            for (int j = n - 1; j >= 0; --j) {
                const double left = j > 0 ? value[at(j - 1)] : 0.0;
                value[at(j)] = ((f + j) * value[at(j)] + (n - f - j) * left) / (n - 1);
            }
        }
    }

  private:
    static std::size_t at(int j) noexcept { return static_cast<std::size_t>(j); }
};

}  // namespace dlpoly::charge
