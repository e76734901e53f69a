// The pairs of a row in rounds: no two pairs of a round share a bead, and every bead meets its pairs in the order of
// the row. Pairs without a common bead do not feel each other's turn, so that a sweep that takes all pairs of a round
// at once, round after round, gives the bits of one that takes the pairs of the row one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sweep/pair_rows.hpp"

namespace dlpoly {

class PairRounds {
  public:
    // Of a row whose beads are numbered below `beads`.
    void arrange(const PairRows::Row& row, std::size_t beads);

    // Where each pair of the row stands among all, round after round.
    [[nodiscard]] const std::vector<std::uint32_t>& place() const noexcept { return place_; }
    // Round n holds the places [start()[n], start()[n + 1]).
    [[nodiscard]] const std::vector<std::uint32_t>& start() const noexcept { return start_; }
    [[nodiscard]] std::size_t count() const noexcept { return start_.size() - 1; }

  private:
    std::vector<std::uint32_t> place_;
    std::vector<std::uint32_t> start_{0};
    std::vector<std::uint32_t> next_;  // by bead: the round after its last one, counted through all rows
    std::uint32_t first_ = 0;          // number of the row's first round, counted through all rows
};

}  // namespace dlpoly
