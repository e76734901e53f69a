// Pairs of beads that the pair loop leaves out because a bonded term takes their place: each bead's partners, sorted.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace dlpoly {

class Exclusions {
  public:
    Exclusions() = default;

    // Every pair once, in any order. Throws std::invalid_argument for beads that do not exist.
    Exclusions(std::size_t beads, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs)
        : start_(beads + 1, 0), partners_(2 * pairs.size()) {
        for (const auto& [i, j] : pairs) {
            if (i >= beads || j >= beads || i == j) {
                throw std::invalid_argument("an excluded pair needs two different beads that exist");
            }
            ++start_[i + 1];
            ++start_[j + 1];
        }
        for (std::size_t i = 0; i < beads; ++i) {
            start_[i + 1] += start_[i];
        }
        std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
        for (const auto& [i, j] : pairs) {
            partners_[next[i]++] = j;
            partners_[next[j]++] = i;
        }
        for (std::size_t i = 0; i < beads; ++i) {
            std::sort(partners_.begin() + static_cast<std::ptrdiff_t>(start_[i]),
                      partners_.begin() + static_cast<std::ptrdiff_t>(start_[i + 1]));
        }
    }

    [[nodiscard]] bool empty() const noexcept { return partners_.empty(); }

    // Whether the pair of these ids is left out, in every periodic image.
    [[nodiscard]] bool contains(std::uint32_t i, std::uint32_t j) const noexcept {
        const std::size_t begin = start_[i];
        const std::size_t end = start_[i + 1];
        return begin != end && std::binary_search(partners_.begin() + static_cast<std::ptrdiff_t>(begin),
                                                  partners_.begin() + static_cast<std::ptrdiff_t>(end), j);
    }

  private:
    std::vector<std::size_t> start_;
    std::vector<std::uint32_t> partners_;
};

}  // namespace dlpoly
