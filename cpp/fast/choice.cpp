// The instruction set of the fast path, chosen at run time (see arguments.hpp).
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "fast/fluid.hpp"

namespace dlpoly::fast {

const Passes& chosen_passes() {
    const char* wish = std::getenv("PYDLPOLY_SIMD");
    const std::string name = wish == nullptr ? "" : wish;
    const Passes* best = avx512_passes() != nullptr ? avx512_passes()
                         : avx2_passes() != nullptr ? avx2_passes()
                                                    : &plain_passes();
    if (name.empty()) {
        return *best;
    }
    const Passes* chosen = name == "plain"    ? &plain_passes()
                           : name == "avx2"   ? avx2_passes()
                           : name == "avx512" ? avx512_passes()
                                              : nullptr;
    if (chosen == nullptr) {
        throw std::invalid_argument("PYDLPOLY_SIMD is '" + name +
                                    "'; expected plain, avx2 or avx512, as far as this processor has them");
    }
    return *chosen;
}

}  // namespace dlpoly::fast
