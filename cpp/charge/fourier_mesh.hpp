// A periodic mesh of complex numbers and its discrete Fourier transform along all three axes, by Eigen's FFT.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace dlpoly::charge {

class FourierMesh {
  public:
    using Complex = std::complex<double>;

    explicit FourierMesh(const std::array<std::int32_t, 3>& points);
    FourierMesh(const FourierMesh&) = delete;
    FourierMesh& operator=(const FourierMesh&) = delete;
    FourierMesh(FourierMesh&&) = delete;
    FourierMesh& operator=(FourierMesh&&) = delete;
    ~FourierMesh();

    [[nodiscard]] const std::array<std::int32_t, 3>& points() const noexcept { return points_; }
    // The first axis runs fastest.
    [[nodiscard]] std::vector<Complex>& values() noexcept { return values_; }
    [[nodiscard]] std::size_t index(std::int32_t a, std::int32_t b, std::int32_t c) const noexcept {
        return static_cast<std::size_t>((std::int64_t{c} * points_[1] + b) * points_[0] + a);
    }

    void forward() { transform(true); }
    // Without the factor 1/points.
    void backward() { transform(false); }

  private:
    struct Plans;

    void transform(bool forward);

    std::array<std::int32_t, 3> points_;
    std::vector<Complex> values_;
    std::unique_ptr<Plans> plans_;
};

}  // namespace dlpoly::charge
