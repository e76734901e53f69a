// Writes the pair noise as a stream of 32-bit words, for batteries of statistical tests; docs/noise.md says how.
//
//   stream FILE SEED [STEP]
//
// FILE holds pair lists: for each, a 64-bit count and then two 32-bit bead ids a pair. The lists are used in turn, one a
// step, from step STEP on, without end; every pair gives the integer that the core scales to its noise.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/random.hpp"

namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

std::vector<Pairs> read_lists(const char* path) {
    std::vector<Pairs> lists;
    std::FILE* file = std::fopen(path, "rb");
    if (file == nullptr) {
        return lists;
    }
    std::uint64_t count = 0;
    while (std::fread(&count, sizeof count, 1, file) == 1) {
        Pairs pairs(count);
        if (std::fread(pairs.data(), sizeof pairs[0], count, file) != count) {
            lists.clear();
            break;
        }
        lists.push_back(std::move(pairs));
    }
    std::fclose(file);
    return lists;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fputs("usage: stream FILE SEED [STEP]\n", stderr);
        return 2;
    }
    const std::vector<Pairs> lists = read_lists(argv[1]);
    std::uint32_t beads = 0;
    for (const Pairs& pairs : lists) {
        for (const auto& pair : pairs) {
            beads = std::max(beads, std::max(pair[0], pair[1]) + 1);
        }
    }
    if (beads == 0) {
        std::fprintf(stderr, "%s holds no whole pair lists\n", argv[1]);
        return 1;
    }
    const std::uint64_t seed = std::strtoull(argv[2], nullptr, 0);
    std::vector<std::uint32_t> words(beads);
    std::vector<std::int32_t> mixed;
    for (std::uint64_t step = argc > 3 ? std::strtoull(argv[3], nullptr, 0) : 1;; ++step) {
        const auto key = dlpoly::bead_word_key(seed, step);
        for (std::uint32_t id = 0; id < beads; ++id) {
            words[id] = dlpoly::bead_word(id, key.data());
        }
        const Pairs& pairs = lists[step % lists.size()];
        mixed.clear();
        for (const auto& [i, j] : pairs) {
            mixed.push_back(dlpoly::mix_words(words[i], words[j]));
        }
        if (std::fwrite(mixed.data(), sizeof mixed[0], mixed.size(), stdout) != mixed.size()) {
            return 0;  // the reader has had enough
        }
    }
}
