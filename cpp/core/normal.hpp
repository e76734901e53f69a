// A standard normal number from one random word of 32 bits, by the inverse of the normal distribution function.
#pragma once

#include <array>
#include <cstdint>

namespace dlpoly {

// Inverse of the standard normal distribution function for 0 < p < 1: the rational approximation of Acklam (2003),
// improved by one step of Halley's method to the accuracy of erfc.
double inverse_normal(double p) noexcept;

// Normal numbers whose quantiles are read from a table between the tails and computed in them. The table's straight
// pieces change moments by less than 1e-5.
class NormalTable {
  public:
    NormalTable();

    // `word` is uniform over all 32-bit integers.
    [[nodiscard]] double operator()(std::int32_t word) const noexcept {
        const auto bits = static_cast<std::uint32_t>(word);
        const std::uint32_t piece = bits >> (32 - piece_bits);
        if (piece - tail_pieces < pieces - 2 * tail_pieces) {
            const double part = static_cast<double>(bits & ((1U << (32 - piece_bits)) - 1U)) + 0.5;
            const double low = quantile_[piece];
            return low + (quantile_[piece + 1] - low) * (part * (1.0 / (1U << (32 - piece_bits))));
        }
        return inverse_normal((static_cast<double>(bits) + 0.5) * 0x1p-32);
    }

  private:
    static constexpr std::uint32_t piece_bits = 11;
    static constexpr std::uint32_t pieces = 1U << piece_bits;
    static constexpr std::uint32_t tail_pieces = 16;
    std::array<float, pieces + 1> quantile_{};
};

// The one table of the program.
const NormalTable& normal_table();

}  // namespace dlpoly
