// Counter-based random numbers: a draw is a pure function of (seed, stream, step, two ids, image), so it does not
// depend on threads, cell layout, pair order or restarts, and no generator state has to be saved.
//
// The generator is Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3"
// (2011).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/bead_words.hpp"
#include "core/streams.hpp"
#include "core/types.hpp"

namespace dlpoly {

using Words = std::array<std::uint32_t, 4>;

// Ten rounds of Philox4x32 on one counter under one key.
inline Words philox(Words counter, std::uint64_t key) noexcept {
    auto key_low = static_cast<std::uint32_t>(key);
    auto key_high = static_cast<std::uint32_t>(key >> 32);
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t a = std::uint64_t{0xD2511F53U} * counter[0];
        const std::uint64_t b = std::uint64_t{0xCD9E8D57U} * counter[2];
        counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key_low, static_cast<std::uint32_t>(b),
                   static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key_high, static_cast<std::uint32_t>(a)};
        key_low += 0x9E3779B9U;
        key_high += 0xBB67AE85U;
    }
    return counter;
}

// The four words of one draw. Steps up to 2^48 and ids up to 2^32 are distinct; `image` tells several periodic images
// of one pair apart in boxes smaller than twice the cutoff and is 0 elsewhere.
inline Words draw(std::uint64_t seed, Stream stream, std::uint64_t step, std::uint32_t first_id,
                  std::uint32_t second_id, std::uint8_t image = 0) noexcept {
    const auto step_high = static_cast<std::uint32_t>((step >> 32) & 0xFFFFU);
    const std::uint32_t purpose =
        step_high | (static_cast<std::uint32_t>(stream) << 16) | (static_cast<std::uint32_t>(image) << 24);
    return philox({static_cast<std::uint32_t>(step), purpose, first_id, second_id}, seed);
}

// Uniform in (0, 1), never 0 or 1, from two words.
inline double uniform(std::uint32_t high, std::uint32_t low) noexcept {
    const std::uint64_t bits = ((static_cast<std::uint64_t>(high) << 32) | low) >> 12;
    return (static_cast<double>(bits) + 0.5) * 0x1p-52;
}

// Two independent standard normal numbers by the Box–Muller transform, which never rejects a draw: rejection would tie
// consecutive steps together.
inline std::array<double, 2> gaussian_pair(const Words& words) noexcept {
    const double radius = std::sqrt(-2.0 * std::log(uniform(words[0], words[1])));
    const double angle = 2.0 * pi * uniform(words[2], words[3]);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

inline double gaussian(const Words& words) noexcept {
    const double radius = std::sqrt(-2.0 * std::log(uniform(words[0], words[1])));
    return radius * std::cos(2.0 * pi * uniform(words[2], words[3]));
}

// ζ_ij of a pair of beads in a step: standard normal and symmetric in i and j.
inline double pair_noise(std::uint64_t seed, std::uint64_t step, std::uint32_t i, std::uint32_t j,
                         std::uint8_t image = 0) noexcept {
    return gaussian(draw(seed, Stream::pair_noise, step, i < j ? i : j, i < j ? j : i, image));
}

// The key under which bead_word makes the words of a step.
inline std::array<std::uint32_t, 3> bead_word_key(std::uint64_t seed, std::uint64_t step,
                                                  Stream stream = Stream::bead_words) noexcept {
    const Words words = draw(seed, stream, step & ~std::uint64_t{0xFFFFFFFFU}, 0, 0);
    return {words[0], words[1], words[2] ^ static_cast<std::uint32_t>(step)};
}

}  // namespace dlpoly
