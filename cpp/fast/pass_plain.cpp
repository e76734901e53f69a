// The plain passes: any compiler, any processor, and the reference for the vector ones.
#define DLPOLY_SIMD plain
#include "fast/pass.hpp"
#include "fast/variants.hpp"

namespace dlpoly::fast {

namespace {

Pass<MixedRecord> mixed(Variant variant) { return DLPOLY_CHOOSE_PASS(plain::plain_pass, MixedRecord, variant); }
Pass<DoubleRecord> in_double(Variant variant) { return DLPOLY_CHOOSE_PASS(plain::plain_pass, DoubleRecord, variant); }

}  // namespace

const Passes& plain_passes() {
    static constexpr Passes passes{"plain", &mixed, &in_double};
    return passes;
}

}  // namespace dlpoly::fast
