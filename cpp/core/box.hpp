// The simulation cell: cell vectors, periodic axes, wrapping, volume. The origin is the centre of the cell, as in
// DL_POLY.
#pragma once

#include <array>
#include <cstdint>

#include "core/types.hpp"

namespace dlpoly {

class Box {
  public:
    // cell: one cell vector a row; axes that are not periodic only give the extent for the volume.
    // Throws std::invalid_argument for a cell without volume.
    Box(const Matrix3& cell, std::array<bool, 3> periodic);

    [[nodiscard]] const Matrix3& cell() const noexcept { return cell_; }
    [[nodiscard]] const std::array<bool, 3>& periodic() const noexcept { return periodic_; }
    [[nodiscard]] double volume() const noexcept { return volume_; }

    // Perpendicular distances between opposite faces.
    [[nodiscard]] const Vector3& widths() const noexcept { return widths_; }

    // Coordinates in units of the cell vectors; [−½, ½) inside the cell.
    [[nodiscard]] Vector3 fractional(const Vector3& position) const noexcept { return position.transpose() * inverse_; }

    // Moves a position into the cell along periodic axes and counts the cells it was moved by.
    // Returns false, with nothing changed, when the position is not finite or more than 2^30 cells away.
    bool wrap(Eigen::Ref<Vector3> position, std::int32_t* image) const noexcept;

    // The position of a bead before it was wrapped.
    [[nodiscard]] Vector3 unwrapped(const Vector3& position, const std::int32_t* image) const noexcept {
        return position + (cell_.row(0) * image[0] + cell_.row(1) * image[1] + cell_.row(2) * image[2]).transpose();
    }

  private:
    Matrix3 cell_;
    Matrix3 inverse_;
    std::array<bool, 3> periodic_;
    double volume_;
    Vector3 widths_;
};

}  // namespace dlpoly
