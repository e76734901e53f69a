// Numbered lattice vectors (see lattice_shifts.hpp).
#include "forces/lattice_shifts.hpp"

namespace dlpoly {

namespace {

// Tells lattice vectors apart by a small number, 0 for the cell itself.
std::uint8_t image_code(const std::array<std::int32_t, 3>& shift, int sign) {
    std::int32_t code = 0;
    for (const std::int32_t s : shift) {
        code = code * 6 + ((sign * s) % 6 + 6) % 6;
    }
    return static_cast<std::uint8_t>(code);
}

}  // namespace

void LatticeShifts::number(const Box& box, const std::array<std::int32_t, 3>& reach, bool several_images) {
    stride = {1, 2 * reach[0] + 1, std::int64_t{2 * reach[0] + 1} * (2 * reach[1] + 1)};
    zero = reach[0] + reach[1] * stride[1] + reach[2] * stride[2];
    vectors.clear();
    codes.clear();
    for (std::int32_t c = -reach[2]; c <= reach[2]; ++c) {
        for (std::int32_t b = -reach[1]; b <= reach[1]; ++b) {
            for (std::int32_t a = -reach[0]; a <= reach[0]; ++a) {
                const Vector3 shift =
                    (box.cell().row(0) * a + box.cell().row(1) * b + box.cell().row(2) * c).transpose();
                vectors.push_back({shift[0], shift[1], shift[2], 0.0});
                if (several_images) {
                    codes.push_back({{image_code({a, b, c}, 1), image_code({a, b, c}, -1)}});
                }
            }
        }
    }
}

}  // namespace dlpoly
