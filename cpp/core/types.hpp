// The arithmetic types of the core: the only place that says double and how an N×3 array is laid out.
#pragma once

#include <Eigen/Dense>
#include <cstdint>

namespace dlpoly {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Array3N = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // one bead a row, as NumPy has it
using ArrayXN = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // one bead a row
using Image3N = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

inline constexpr double pi = 3.14159265358979323846;

}  // namespace dlpoly
