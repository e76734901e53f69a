// Random words of beads and their symmetric mix: the cheap pair noise.
//
// A strong generator makes one word for each bead and step; a pair's noise is a short symmetric mix of two words. The
// functions have internal linkage because they are compiled for several instruction sets.
#pragma once

#include <stdint.h>

namespace dlpoly {

// A bead's random word of a step: Philox2x32-10 (Salmon et al. 2011) of (id, step). key[0] is the generator's key,
// key[1] and key[2] scramble its counter; key[2] also holds the step.
static inline uint32_t bead_word(uint32_t id, const uint32_t* key) noexcept {
    uint32_t low = id ^ key[1];
    uint32_t high = key[2];
    uint32_t round_key = key[0];
    for (int round = 0; round < 10; ++round) {
        const uint64_t product = uint64_t{0xD256D193U} * low;
        low = static_cast<uint32_t>(product >> 32) ^ round_key ^ high;
        high = static_cast<uint32_t>(product);
        round_key += 0x9E3779B9U;
    }
    return low;
}

// One uniform 32-bit integer for the pair. `image` tells several periodic images of one pair apart.
static inline int32_t mix_words(uint32_t a, uint32_t b, uint32_t image = 0) noexcept {
    uint32_t x = a + b + image * 0x9E3779B9U;
    x ^= x >> 16;
    x *= 0x7feb352dU;
    x ^= x >> 15;
    x *= 0x846ca68bU;
    return static_cast<int32_t>(x);
}

// √3/2³¹: makes a uniform 32-bit integer a number of unit variance.
inline constexpr double word_to_noise = 1.7320508075688772 * 0x1p-31;

}  // namespace dlpoly
