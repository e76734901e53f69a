// The phases for any compiler and any processor, and the choice between the sets.
#define DLPOLY_SIMD plain
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "forces/pair_phases_loops.hpp"

namespace dlpoly {

const Phases& plain_phases() {
    static constexpr Phases phases{"plain",       &plain::search, &plain::filter, &plain::motion,
                                   &plain::round, &plain::add,    &plain::observe};
    return phases;
}

const Phases& chosen_phases() {
    const char* wish = std::getenv("PYDLPOLY_SIMD");
    const std::string name = wish == nullptr ? "" : wish;
    const Phases* const sets[] = {avx512_phases(), avx2_phases(), &plain_phases()};
    for (const Phases* phases : sets) {
        if (phases != nullptr && (name.empty() || name == phases->name)) {
            return *phases;
        }
    }
    throw std::invalid_argument("PYDLPOLY_SIMD is '" + name +
                                "'; expected plain, avx2 or avx512, as far as this processor has them");
}

}  // namespace dlpoly
