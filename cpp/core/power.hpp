// Powers of numbers in (0, 1] by plain additions and multiplications, which compilers turn into vectors and which give
// the same bits on every instruction set: b^p = exp(p ln b), right to 2e-15 (1 + p |ln b|) relative.
#pragma once

#include <bit>
#include <cstdint>

#if defined(__GNUC__)
#define DLPOLY_INLINE_POWER [[gnu::always_inline]] inline
#else
#define DLPOLY_INLINE_POWER inline
#endif

namespace dlpoly {

namespace power {

inline constexpr double ln2_high = 0x1.62e42fefa3800p-1;  // whole multiples of it below 2^11 are exact
inline constexpr double ln2_low = 0x1.ef35793c76730p-45;
inline constexpr double round_offset = 0x1.8p52;  // added to a number below 2^51, leaves it rounded in the low bits

// ln b of a normal number: b = 2^e m with m in [√½, √2), ln m = 2 artanh((m − 1)/(m + 1)).
DLPOLY_INLINE_POWER double logarithm(double base) noexcept {
    constexpr std::uint64_t root_half = 0x3fe6a09e667f3bcdU;
    const auto bits = std::bit_cast<std::uint64_t>(base);
    const std::uint64_t above = bits - root_half + 0x3ff0000000000000U;  // its exponent field is that of m = √½ … √2
    const std::uint64_t field = above >> 52;
    const double exponent = std::bit_cast<double>(0x4330000000000000U | field) - (0x1p52 + 1023.0);
    const double mantissa = std::bit_cast<double>(bits - ((field - 1023U) << 52));
    const double s = (mantissa - 1.0) / (mantissa + 1.0);
    const double z = s * s;
    double sum = 1.0 / 21.0;
    sum = sum * z + 1.0 / 19.0;
    sum = sum * z + 1.0 / 17.0;
    sum = sum * z + 1.0 / 15.0;
    sum = sum * z + 1.0 / 13.0;
    sum = sum * z + 1.0 / 11.0;
    sum = sum * z + 1.0 / 9.0;
    sum = sum * z + 1.0 / 7.0;
    sum = sum * z + 1.0 / 5.0;
    sum = sum * z + 1.0 / 3.0;
    const double rest = 2.0 * s + (2.0 * s * z) * sum;
    return exponent * ln2_high + (rest + exponent * ln2_low);
}

// e^y for |y| < 700; larger ones are taken as ±700.
DLPOLY_INLINE_POWER double exponential(double y) noexcept {
    const double inside = y < -700.0 ? -700.0 : (y > 700.0 ? 700.0 : y);
    const double shifted = inside * 0x1.71547652b82fep0 + round_offset;
    const double n = shifted - round_offset;
    const double r = (inside - n * ln2_high) - n * ln2_low;
    double sum = 1.0 / 6227020800.0;
    sum = sum * r + 1.0 / 479001600.0;
    sum = sum * r + 1.0 / 39916800.0;
    sum = sum * r + 1.0 / 3628800.0;
    sum = sum * r + 1.0 / 362880.0;
    sum = sum * r + 1.0 / 40320.0;
    sum = sum * r + 1.0 / 5040.0;
    sum = sum * r + 1.0 / 720.0;
    sum = sum * r + 1.0 / 120.0;
    sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0;
    sum = sum * r + 0.5;
    const double value = 1.0 + (r + r * r * sum);
    const std::uint64_t scale = (std::bit_cast<std::uint64_t>(shifted) << 52) + 0x3ff0000000000000U;
    return value * std::bit_cast<double>(scale);
}

}  // namespace power

// 0 for a base that is 0 or less.
DLPOLY_INLINE_POWER double power_of(double base, double exponent) noexcept {
    const bool some = base > 0.0;
    const double value = power::exponential(exponent * power::logarithm(some ? base : 1.0));
    return some ? value : 0.0;
}

}  // namespace dlpoly
