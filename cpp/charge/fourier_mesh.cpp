// Fourier transforms of a mesh (see fourier_mesh.hpp).
#include "charge/fourier_mesh.hpp"

#include <unsupported/Eigen/FFT>

#include "core/threads.hpp"

namespace dlpoly::charge {

// One a thread: a plan keeps its factors and a workspace.
struct FourierMesh::Plans {
    std::vector<Eigen::FFT<double>> of_thread;
};

FourierMesh::FourierMesh(const std::array<std::int32_t, 3>& points)
    : points_(points),
      values_(static_cast<std::size_t>(std::int64_t{points[0]} * points[1] * points[2])),
      plans_(std::make_unique<Plans>()) {}

FourierMesh::~FourierMesh() = default;

void FourierMesh::transform(bool forward) {
    while (plans_->of_thread.size() < static_cast<std::size_t>(thread_limit())) {
        // A copy: some versions of Eigen declare the flag without a definition, so that nothing may refer to it.
        using Fft = Eigen::FFT<double>;
        plans_->of_thread.emplace_back(Fft::impl_type(), Fft::Flag{Fft::Unscaled});
    }
    std::int64_t stride = 1;
    for (const std::int32_t length : points_) {
        const auto lines = static_cast<std::int64_t>(values_.size()) / length;
#ifdef _OPENMP
#pragma omp parallel
#endif
        {
            Eigen::FFT<double>& plan = plans_->of_thread[static_cast<std::size_t>(thread_number())];
            std::vector<Complex> line(static_cast<std::size_t>(length));
            std::vector<Complex> result(static_cast<std::size_t>(length));
#ifdef _OPENMP
#pragma omp for schedule(static)
#endif
            for (std::int64_t k = 0; k < lines; ++k) {
                Complex* const first = values_.data() + (k / stride) * stride * length + k % stride;
                for (std::int32_t n = 0; n < length; ++n) {
                    line[static_cast<std::size_t>(n)] = first[n * stride];
                }
                if (forward) {
                    plan.fwd(result.data(), line.data(), length);
                } else {
                    plan.inv(result.data(), line.data(), length);
                }
                for (std::int32_t n = 0; n < length; ++n) {
                    first[n * stride] = result[static_cast<std::size_t>(n)];
                }
            }
        }
        stride *= length;
    }
}

}  // namespace dlpoly::charge
