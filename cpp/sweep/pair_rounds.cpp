// The pairs of a row in rounds (see pair_rounds.hpp).
#include "sweep/pair_rounds.hpp"

#include <algorithm>
#include <limits>

namespace dlpoly {

void PairRounds::arrange(const PairRows::Row& row, std::size_t beads) {
    const std::size_t pairs = row.size();
    // What earlier rows left behind lies below `first_` and holds nobody up.
    if (next_.size() < beads || first_ > std::numeric_limits<std::uint32_t>::max() / 2) {
        next_.assign(std::max(beads, next_.size()), 0);
        first_ = 0;
    }
    place_.resize(pairs);
    start_.assign(2, 0);
    std::uint32_t most = 0;  // rounds so far
    for (std::size_t k = 0; k < pairs; ++k) {
        std::uint32_t& one = next_[row.i[k]];
        std::uint32_t& other = next_[row.j[k]];
        const std::uint32_t round = std::max({first_, one, other});
        one = round + 1;
        other = round + 1;
        const std::uint32_t number = round - first_;
        place_[k] = number;
        if (number == most) {
            ++most;
            start_.push_back(0);
        }
        ++start_[number + 2];
    }
    first_ += most;
    // Shifted by one: counting the places of a round leaves its end, which is the start of the next.
    for (std::size_t n = 2; n < start_.size(); ++n) {
        start_[n] += start_[n - 1];
    }
    for (std::uint32_t& place : place_) {
        place = start_[place + 1]++;
    }
    start_.pop_back();
}

}  // namespace dlpoly
