#include "fast/arguments.hpp"
namespace dlpoly::fast {
const Passes* avx2_passes() { return nullptr; }
}  // namespace dlpoly::fast
