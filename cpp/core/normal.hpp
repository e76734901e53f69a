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
        return is_tail(word) ? of_tail(word) : between(quantile_.data(), word);
    }

    // Its parts, for loops over many words; between() is finite for all words.
    [[nodiscard]] static bool is_tail(std::int32_t word) noexcept {
        return piece_of(word) - tail_pieces >= pieces - 2 * tail_pieces;
    }
    [[nodiscard]] static double of_tail(std::int32_t word) noexcept {
        return inverse_normal((static_cast<double>(static_cast<std::uint32_t>(word)) + 0.5) * 0x1p-32);
    }
    [[nodiscard]] static double between(const float* quantiles, std::int32_t word) noexcept {
        const auto inside = static_cast<std::int32_t>(static_cast<std::uint32_t>(word) & (piece_size - 1U));
        const double part = static_cast<double>(inside) + 0.5;
        const std::uint32_t piece = piece_of(word);
        const double low = quantiles[piece];
        return low + (quantiles[piece + 1] - low) * (part * (1.0 / piece_size));
    }
    [[nodiscard]] const float* quantiles() const noexcept { return quantile_.data(); }

  private:
    static constexpr std::uint32_t piece_bits = 11;
    static constexpr std::uint32_t pieces = 1U << piece_bits;
    static constexpr std::uint32_t piece_size = 1U << (32 - piece_bits);
    static constexpr std::uint32_t tail_pieces = 16;

    static std::uint32_t piece_of(std::int32_t word) noexcept {
        return static_cast<std::uint32_t>(word) >> (32 - piece_bits);
    }

    std::array<float, pieces + 1> quantile_{};
};

// The one table of the program.
const NormalTable& normal_table();

}  // namespace dlpoly
