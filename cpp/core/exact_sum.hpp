// Sums that do not depend on the order of their terms: every term is rounded once to a common grid of 2^-exponent and
// added as an integer. Forces on beads use one 64-bit integer each, totals over all pairs a 128-bit one.
//
// This is what makes results equal to the bit for any number of threads and any cell layout, and the total force on all
// beads exactly zero.
#pragma once

#include <cmath>
#include <cstdint>

namespace dlpoly {

// Terms beyond this magnitude (in grid units) are refused, so that 2^11 of them cannot overflow 64 bits.
inline constexpr double largest_term = 0x1p51;

// The finest power-of-two grid on which values up to `magnitude` keep a margin of 8 below the largest term.
inline int grid_exponent(double magnitude) noexcept { return 48 - static_cast<int>(std::ceil(std::log2(magnitude))); }

class WideSum {
  public:
    void add(std::int64_t value) noexcept {
        const auto bits = static_cast<std::uint64_t>(value);
        low_ += bits;
        high_ += (value < 0 ? -1 : 0) + (low_ < bits ? 1 : 0);
    }

    void add(const WideSum& other) noexcept {
        low_ += other.low_;
        high_ += other.high_ + (low_ < other.low_ ? 1 : 0);
    }

    // The sum in the terms' own unit, rounded once. Negative sums are negated first: their two words, taken apart,
    // would be rounded at the size of the upper one.
    [[nodiscard]] double value(int exponent) const noexcept {
        const bool negative = high_ < 0;
        const std::uint64_t low = negative ? ~low_ + 1 : low_;
        const auto high = static_cast<std::uint64_t>(high_);
        const std::uint64_t upper = negative ? ~high + (low == 0 ? 1 : 0) : high;
        const double size =
            std::ldexp(static_cast<double>(upper), 64 - exponent) + std::ldexp(static_cast<double>(low), -exponent);
        return negative ? -size : size;
    }

  private:
    std::uint64_t low_ = 0;
    std::int64_t high_ = 0;
};

}  // namespace dlpoly
