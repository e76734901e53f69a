// The plain sum over reciprocal vectors (see reciprocal.hpp).
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "charge/reciprocal.hpp"

namespace dlpoly::charge {

namespace {

using Complex = std::complex<double>;

// One of every two vectors k and −k.
struct Wave {
    std::array<std::int32_t, 3> n;
    Vector3 k;
    double squared;
    double weight;  // 2·(4π/V) e^(−k²/4α²)/k², the factor 2 for −k
};

class PlainSum final : public Reciprocal {
  public:
    PlainSum(double alpha, const std::array<std::int32_t, 3>& counts) : alpha_(alpha), counts_(counts) {}

    void compute(const Box& box, const Array3N& positions, std::span<const double> charges, Array3N* forces,
                 ReciprocalTotals* totals) override;
    double curvature(const Box& box, const Array3N& positions, std::span<const double> charges,
                     std::span<const std::uint8_t> frozen) override;

  private:
    void choose_waves(const Box& box);
    void find_phases(const Box& box, const Array3N& positions);
    void find_structure(std::span<const double> charges);
    [[nodiscard]] Complex phase(const Wave& wave, std::size_t i) const;

    double alpha_;
    std::array<std::int32_t, 3> counts_;
    Matrix3 cell_ = Matrix3::Zero();  // that the waves belong to
    std::vector<Wave> waves_;
    std::vector<Complex> structure_;              // Σ q e^(ik·r), by wave
    std::array<std::vector<Complex>, 3> phases_;  // e^(2πi n s), n = 0 … counts, a charge
};

void PlainSum::choose_waves(const Box& box) {
    if (box.cell() == cell_) {
        return;
    }
    cell_ = box.cell();
    waves_.clear();
    const Matrix3 rows = reciprocal_vectors(box);
    double longest = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // n_a = k·a/2π: every vector shorter than this has its numbers within the counts.
        longest = std::min(longest, 2.0 * pi * (counts_[axis] + 1) / cell_.row(static_cast<Eigen::Index>(axis)).norm());
    }
    for (std::int32_t a = 0; a <= counts_[0]; ++a) {
        for (std::int32_t b = a > 0 ? -counts_[1] : 0; b <= counts_[1]; ++b) {
            for (std::int32_t c = a > 0 || b > 0 ? -counts_[2] : 1; c <= counts_[2]; ++c) {
                const Vector3 k = (rows.row(0) * a + rows.row(1) * b + rows.row(2) * c).transpose();
                const double squared = k.squaredNorm();
                if (squared < longest * longest * (1.0 - 1e-9)) {
                    const double fade = std::exp(-squared / (4.0 * alpha_ * alpha_));
                    waves_.push_back({{a, b, c}, k, squared, 8.0 * pi / box.volume() * fade / squared});
                }
            }
        }
    }
}

void PlainSum::find_phases(const Box& box, const Array3N& positions) {
    const auto charges = static_cast<std::int64_t>(positions.rows());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        phases_[axis].resize(static_cast<std::size_t>(charges * (counts_[axis] + 1)));
    }
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t i = 0; i < charges; ++i) {
        const Vector3 s = box.fractional(positions.row(i).transpose());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::int32_t n = 0; n <= counts_[axis]; ++n) {
                phases_[axis][static_cast<std::size_t>(i * (counts_[axis] + 1) + n)] =
                    std::polar(1.0, 2.0 * pi * n * s[static_cast<Eigen::Index>(axis)]);
            }
        }
    }
}

Complex PlainSum::phase(const Wave& wave, std::size_t i) const {
    Complex product = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t n = wave.n[axis];
        const Complex one =
            phases_[axis][i * static_cast<std::size_t>(counts_[axis] + 1) + static_cast<std::size_t>(std::abs(n))];
        const Complex turned = n < 0 ? std::conj(one) : one;
        product = Complex(product.real() * turned.real() - product.imag() * turned.imag(),
                          product.real() * turned.imag() + product.imag() * turned.real());
    }
    return product;
}

void PlainSum::find_structure(std::span<const double> charges) {
    structure_.resize(waves_.size());
    const auto count = static_cast<std::int64_t>(waves_.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t w = 0; w < count; ++w) {
        Complex sum = 0.0;
        for (std::size_t i = 0; i < charges.size(); ++i) {
            sum += charges[i] * phase(waves_[static_cast<std::size_t>(w)], i);
        }
        structure_[static_cast<std::size_t>(w)] = sum;
    }
}

void PlainSum::compute(const Box& box, const Array3N& positions, std::span<const double> charges, Array3N* forces,
                       ReciprocalTotals* totals) {
    choose_waves(box);
    find_phases(box, positions);
    find_structure(charges);
    if (totals != nullptr) {
        *totals = {};
        for (std::size_t w = 0; w < waves_.size(); ++w) {
            const Wave& wave = waves_[w];
            const double energy = 0.5 * wave.weight * std::norm(structure_[w]);
            const double stretch = 2.0 / wave.squared + 0.5 / (alpha_ * alpha_);
            totals->energy += energy;
            totals->virial += energy * (Matrix3::Identity() - stretch * wave.k * wave.k.transpose());
        }
    }
    if (forces == nullptr) {
        return;
    }
    forces->resize(positions.rows(), 3);
    const auto count = static_cast<std::int64_t>(charges.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t c = 0; c < count; ++c) {
        const auto i = static_cast<std::size_t>(c);
        Vector3 force = Vector3::Zero();
        for (std::size_t w = 0; w < waves_.size(); ++w) {
            const Complex turned = phase(waves_[w], i);
            const double sine = turned.imag() * structure_[w].real() - turned.real() * structure_[w].imag();
            force += (waves_[w].weight * sine) * waves_[w].k;
        }
        forces->row(c) = charges[i] * force.transpose();
    }
}

double PlainSum::curvature(const Box& box, const Array3N& positions, std::span<const double> charges,
                           std::span<const std::uint8_t> frozen) {
    choose_waves(box);
    find_phases(box, positions);
    find_structure(charges);
    double sum = 0.0;
    for (std::size_t w = 0; w < waves_.size(); ++w) {
        double waves = 0.0;
        for (std::size_t i = 0; i < charges.size(); ++i) {
            if (frozen[i] == 0) {
                waves += charges[i] * ((std::conj(phase(waves_[w], i)) * structure_[w]).real() - charges[i]);
            }
        }
        sum -= waves_[w].weight * waves_[w].squared * waves;
    }
    return sum;
}

}  // namespace

std::unique_ptr<Reciprocal> make_plain_sum(double alpha, const std::array<std::int32_t, 3>& counts) {
    return std::make_unique<PlainSum>(alpha, counts);
}

}  // namespace dlpoly::charge
