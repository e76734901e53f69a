// Smooth particle mesh Ewald (see reciprocal.hpp; Essmann and others, J. Chem. Phys. 103, 8577 (1995)).
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include "charge/bspline.hpp"
#include "charge/fourier_mesh.hpp"
#include "charge/reciprocal.hpp"

namespace dlpoly::charge {

namespace {

using Complex = std::complex<double>;

std::size_t at(std::int64_t k) { return static_cast<std::size_t>(k); }

// Where a charge stands on the mesh.
struct Place {
    std::array<std::int32_t, 3> base;  // the last point that its splines reach along each axis
    std::array<BSpline, 3> spline;
};

class MeshSum final : public Reciprocal {
  public:
    MeshSum(double alpha, const std::array<std::int32_t, 3>& points, int order);

    void compute(const Box& box, const Array3N& positions, std::span<const double> charges, Array3N* forces,
                 ReciprocalTotals* totals) override;
    double curvature(const Box& box, const Array3N& positions, std::span<const double> charges,
                     std::span<const std::uint8_t> frozen) override;

  private:
    void place(const Box& box, const Array3N& positions);
    void spread(std::span<const double> charges);
    [[nodiscard]] Vector3 wave(const Matrix3& rows, std::int32_t a, std::int32_t b, std::int32_t c) const;
    void update_weights(const Box& box);
    ReciprocalTotals filter(const Box& box, bool by_square, bool observe);
    template <class Visit>
    void gather(std::size_t i, const Visit& visit);

    double alpha_;
    int order_;
    FourierMesh mesh_;
    std::array<std::vector<double>, 3> moduli_;  // |b(m)|² of the splines along each axis
    Matrix3 cell_ = Matrix3::Zero();             // that the weights belong to
    std::vector<double> weights_;                // what multiplies |Q(m)|²/2 in the energy, by mesh point
    std::vector<Place> places_;
    std::vector<std::vector<std::uint32_t>> by_base_;  // charges by their base along the last axis, ascending
};

MeshSum::MeshSum(double alpha, const std::array<std::int32_t, 3>& points, int order)
    : alpha_(alpha), order_(order), mesh_(points) {
    const BSpline nodes(0.0, order);  // M_p(0), M_p(1), …
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t length = points[axis];
        for (std::int32_t m = 0; m < length; ++m) {
            Complex sum = 0.0;
            for (int k = 0; k <= order - 2; ++k) {
                sum += nodes.value[at(k + 1)] * std::polar(1.0, 2.0 * pi * m * k / length);
            }
            moduli_[axis].push_back(1.0 / std::norm(sum));
        }
    }
}

void MeshSum::place(const Box& box, const Array3N& positions) {
    const auto count = static_cast<std::int64_t>(positions.rows());
    places_.resize(at(count), Place{{}, {BSpline(0.0, 2), BSpline(0.0, 2), BSpline(0.0, 2)}});
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t i = 0; i < count; ++i) {
        const Vector3 s = box.fractional(positions.row(i).transpose());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int32_t length = mesh_.points()[axis];
            const double fraction = s[static_cast<Eigen::Index>(axis)];
            const double u = (fraction - std::floor(fraction)) * length;
            const auto base = static_cast<std::int32_t>(std::floor(u));
            places_[at(i)].base[axis] = base % length;
            places_[at(i)].spline[axis] = BSpline(u - base, order_);
        }
    }
    by_base_.resize(at(mesh_.points()[2]));
    for (std::vector<std::uint32_t>& list : by_base_) {
        list.clear();
    }
    for (std::int64_t i = 0; i < count; ++i) {
        by_base_[at(places_[at(i)].base[2])].push_back(static_cast<std::uint32_t>(i));
    }
}

// Each plane of the mesh adds up its charges in one order: by how far their base is, then by number.
void MeshSum::spread(std::span<const double> charges) {
    const auto [nx, ny, nz] = mesh_.points();
    std::vector<Complex>& values = mesh_.values();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int32_t z = 0; z < nz; ++z) {
        std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(mesh_.index(0, 0, z)), std::int64_t{nx} * ny, 0.0);
        for (int c = 0; c < order_; ++c) {
            for (const std::uint32_t i : by_base_[at((z + c) % nz)]) {
                const Place& place = places_[i];
                const double along = charges[i] * place.spline[2].value[at(c)];
                for (int b = 0; b < order_; ++b) {
                    const double across = along * place.spline[1].value[at(b)];
                    const std::int32_t y = (place.base[1] - b + ny) % ny;
                    for (int a = 0; a < order_; ++a) {
                        const std::int32_t x = (place.base[0] - a + nx) % nx;
                        values[mesh_.index(x, y, z)] += across * place.spline[0].value[at(a)];
                    }
                }
            }
        }
    }
}

// The wave vector of a mesh point.
Vector3 MeshSum::wave(const Matrix3& rows, std::int32_t a, std::int32_t b, std::int32_t c) const {
    const std::array<std::int32_t, 3> m{a, b, c};
    Vector3 k = Vector3::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t length = mesh_.points()[axis];
        const std::int32_t n = 2 * m[axis] > length ? m[axis] - length : m[axis];
        k += n * rows.row(static_cast<Eigen::Index>(axis)).transpose();
    }
    return k;
}

void MeshSum::update_weights(const Box& box) {
    if (box.cell() == cell_) {
        return;
    }
    cell_ = box.cell();
    const auto [nx, ny, nz] = mesh_.points();
    const Matrix3 rows = reciprocal_vectors(box);
    weights_.resize(mesh_.values().size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int32_t z = 0; z < nz; ++z) {
        for (std::int32_t y = 0; y < ny; ++y) {
            for (std::int32_t x = 0; x < nx; ++x) {
                const double squared = wave(rows, x, y, z).squaredNorm();
                weights_[mesh_.index(x, y, z)] = 4.0 * pi / box.volume() *
                                                 std::exp(-squared / (4.0 * alpha_ * alpha_)) / squared *
                                                 (moduli_[0][at(x)] * moduli_[1][at(y)] * moduli_[2][at(z)]);
            }
        }
    }
    weights_[0] = 0.0;
}

// Multiplies the transformed mesh by the influence (by_square: times −k² also) and returns what it adds up to; each
// plane has sums of its own.
ReciprocalTotals MeshSum::filter(const Box& box, bool by_square, bool observe) {
    const auto [nx, ny, nz] = mesh_.points();
    const Matrix3 rows = reciprocal_vectors(box);
    update_weights(box);
    std::vector<ReciprocalTotals> planes(at(nz));
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int32_t z = 0; z < nz; ++z) {
        ReciprocalTotals& own = planes[at(z)];
        for (std::int32_t y = 0; y < ny; ++y) {
            for (std::int32_t x = 0; x < nx; ++x) {
                const std::size_t here = mesh_.index(x, y, z);
                Complex& value = mesh_.values()[here];
                if ((observe || by_square) && here != 0) {
                    const Vector3 k = wave(rows, x, y, z);
                    const double squared = k.squaredNorm();
                    const double energy = 0.5 * weights_[here] * std::norm(value);
                    const double stretch = 2.0 / squared + 0.5 / (alpha_ * alpha_);
                    own.energy += energy;
                    own.virial += energy * (Matrix3::Identity() - stretch * k * k.transpose());
                    value *= by_square ? -squared : 1.0;
                }
                value *= weights_[here];
            }
        }
    }
    ReciprocalTotals totals;
    for (const ReciprocalTotals& plane : planes) {
        totals.energy += plane.energy;
        totals.virial += plane.virial;
    }
    return totals;
}

// Calls visit(a, b, c, potential) for the mesh points that a charge's splines reach.
template <class Visit>
void MeshSum::gather(std::size_t i, const Visit& visit) {
    const Place& place = places_[i];
    const auto [nx, ny, nz] = mesh_.points();
    for (int c = 0; c < order_; ++c) {
        const std::int32_t z = (place.base[2] - c + nz) % nz;
        for (int b = 0; b < order_; ++b) {
            const std::int32_t y = (place.base[1] - b + ny) % ny;
            for (int a = 0; a < order_; ++a) {
                const std::int32_t x = (place.base[0] - a + nx) % nx;
                visit(a, b, c, mesh_.values()[mesh_.index(x, y, z)].real());
            }
        }
    }
}

void MeshSum::compute(const Box& box, const Array3N& positions, std::span<const double> charges, Array3N* forces,
                      ReciprocalTotals* totals) {
    place(box, positions);
    spread(charges);
    mesh_.forward();
    const ReciprocalTotals found = filter(box, false, totals != nullptr);
    if (totals != nullptr) {
        *totals = found;
    }
    if (forces == nullptr) {
        return;
    }
    mesh_.backward();
    forces->resize(positions.rows(), 3);
    // ds_a/dr by row, times the points along the axis: the splines' argument is s_a K_a.
    Matrix3 gradients = box.cell().inverse().transpose();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        gradients.row(axis) *= mesh_.points()[static_cast<std::size_t>(axis)];
    }
    const auto count = static_cast<std::int64_t>(charges.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t i = 0; i < count; ++i) {
        Vector3 slope = Vector3::Zero();
        const std::array<BSpline, 3>& spline = places_[at(i)].spline;
        gather(at(i), [&](int a, int b, int c, double potential) {
            slope[0] += spline[0].slope[at(a)] * spline[1].value[at(b)] * spline[2].value[at(c)] * potential;
            slope[1] += spline[0].value[at(a)] * spline[1].slope[at(b)] * spline[2].value[at(c)] * potential;
            slope[2] += spline[0].value[at(a)] * spline[1].value[at(b)] * spline[2].slope[at(c)] * potential;
        });
        forces->row(i) = -charges[at(i)] * (slope.transpose() * gradients);
    }
}

double MeshSum::curvature(const Box& box, const Array3N& positions, std::span<const double> charges,
                          std::span<const std::uint8_t> frozen) {
    place(box, positions);
    spread(charges);
    mesh_.forward();
    filter(box, true, false);
    mesh_.backward();
    // What a charge's own waves add to it.
    const auto [nx, ny, nz] = mesh_.points();
    const Matrix3 rows = reciprocal_vectors(box);
    double own = -1.0;  // without k = 0
    for (std::int32_t z = 0; z < nz; ++z) {
        for (std::int32_t y = 0; y < ny; ++y) {
            for (std::int32_t x = 0; x < nx; ++x) {
                own += std::exp(-wave(rows, x, y, z).squaredNorm() / (4.0 * alpha_ * alpha_));
            }
        }
    }
    own *= 4.0 * pi / box.volume();
    double sum = 0.0;
    for (std::size_t i = 0; i < charges.size(); ++i) {
        if (frozen[i] != 0) {
            continue;
        }
        double bent = 0.0;
        const std::array<BSpline, 3>& spline = places_[i].spline;
        gather(i, [&](int a, int b, int c, double value) {
            bent += spline[0].value[at(a)] * spline[1].value[at(b)] * spline[2].value[at(c)] * value;
        });
        sum += charges[i] * (bent + charges[i] * own);
    }
    return sum;
}

}  // namespace

std::unique_ptr<Reciprocal> make_mesh_sum(double alpha, const std::array<std::int32_t, 3>& counts, int order) {
    return std::make_unique<MeshSum>(alpha, counts, order);
}

}  // namespace dlpoly::charge
