// The simulation cell (see box.hpp).
#include "core/box.hpp"

#include <cmath>
#include <stdexcept>

namespace dlpoly {

Box::Box(const Matrix3& cell, std::array<bool, 3> periodic)
    : cell_(cell), inverse_(cell.inverse()), periodic_(periodic), volume_(std::abs(cell.determinant())) {
    const double scale = cell.row(0).norm() * cell.row(1).norm() * cell.row(2).norm();
    if (!cell.allFinite() || !(volume_ > 1e-12 * scale)) {
        throw std::invalid_argument("the cell vectors span no volume");
    }
    for (int axis = 0; axis < 3; ++axis) {
        widths_[axis] = 1.0 / inverse_.col(axis).norm();
    }
}

bool Box::wrap(Eigen::Ref<Vector3> position, std::int32_t* image) const noexcept {
    constexpr double limit = 1 << 30;
    const Vector3 s = fractional(position);
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(s[axis]) < limit)) {
            return false;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!periodic_[static_cast<std::size_t>(axis)]) {
            continue;
        }
        const double cells = std::floor(s[axis] + 0.5);
        if (cells != 0.0) {
            position -= cells * cell_.row(axis).transpose();
            image[axis] += static_cast<std::int32_t>(cells);
        }
    }
    return true;
}

}  // namespace dlpoly
