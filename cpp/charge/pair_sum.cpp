// The pairs of charges within the cutoff (see pair_sum.hpp).
#include "charge/pair_sum.hpp"

#include <array>
#include <cmath>

#include "bonded/geometry.hpp"
#include "core/threads.hpp"

namespace dlpoly::charge {

namespace {

// Charges below which further threads cost more than they bring.
constexpr Eigen::Index worth_threads = 400;

struct Batch {
    std::size_t size = 0;
    std::array<std::uint32_t, batch_size> i{}, j{};
    std::array<double, batch_size> squared{};
    std::array<Vector3, batch_size> d{};
    std::array<Value, batch_size> values{};
};

}  // namespace

struct PairSum::Walk {
    const Box& box;
    const bonded::MinimumImage nearest;
    const Array3N& positions;
    const Charges& charges;
    Accumulator& total;

    Walk(const Box& in, const Array3N& at, const Charges& of, Accumulator& sum)
        : box(in), nearest(in), positions(at), charges(of), total(sum) {}

    [[nodiscard]] bool is_nearest(const Vector3& d) const noexcept {
        Vector3 shortened = d;
        static_cast<void>(nearest.shorten(shortened));
        return (shortened - d).squaredNorm() < 1e-12 * d.squaredNorm() || d.squaredNorm() == 0.0;
    }
};

// Rows of one group share no bead that they write to, and sums are integers: their order does not matter.
template <class Finish>
void PairSum::visit(Walk& walk, const Finish& finish) {
    const bool parallel = walk.positions.rows() >= worth_threads;
    std::vector<Accumulator> own(static_cast<std::size_t>(parallel ? thread_limit() : 1),
                                 Accumulator(walk.total.request()));
    for (const std::vector<std::int32_t>& rows : cells_.row_groups()) {
        const auto count = static_cast<std::int64_t>(rows.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1) if (parallel)
#endif
        for (std::int64_t k = 0; k < count; ++k) {
            visit_row(walk, rows[static_cast<std::size_t>(k)],
                      own[parallel ? static_cast<std::size_t>(thread_number()) : 0], finish);
        }
    }
    for (const Accumulator& part : own) {
        walk.total.add(part);
    }
}

template <class Finish>
void PairSum::visit_row(Walk& walk, std::int32_t row, Accumulator& own, const Finish& finish) const {
    const std::vector<std::uint32_t>& order = cells_.order();
    const bool any_excluded = !excluded_.empty();
    const std::vector<std::uint8_t>& frozen = walk.charges.frozen;
    Batch batch;
    std::vector<CellImage> neighbours;
    const auto flush = [&] {
        kernel_.evaluate(batch.size, batch.squared.data(), batch.values.data());
        for (std::size_t k = 0; k < batch.size; ++k) {
            finish(batch.i[k], batch.j[k], batch.squared[k], batch.d[k], batch.values[k], own);
        }
        batch.size = 0;
    };
    const auto meet = [&](std::uint32_t i, std::uint32_t j, const Vector3& d) {
        const double squared = d.squaredNorm();
        if (!(squared < squared_cutoff_) || (frozen[i] != 0 && frozen[j] != 0) ||
            (any_excluded && excluded_.contains(i, j) && walk.is_nearest(d))) {
            return;
        }
        batch.i[batch.size] = i;
        batch.j[batch.size] = j;
        batch.d[batch.size] = d;
        batch.squared[batch.size] = squared;
        if (++batch.size == batch_size) {
            flush();
        }
    };
    const std::int32_t length = cells_.row_length();
    for (std::int32_t cell = row * length; cell < (row + 1) * length; ++cell) {
        cells_.neighbours(cell, neighbours);
        for (std::uint32_t a = cells_.start(cell); a < cells_.start(cell + 1); ++a) {
            const std::uint32_t i = order[a];
            const Vector3 at = walk.positions.row(i).transpose();
            for (std::uint32_t b = a + 1; b < cells_.start(cell + 1); ++b) {
                meet(i, order[b], at - walk.positions.row(order[b]).transpose());
            }
            for (const CellImage& image : neighbours) {
                const Vector3 shifted =
                    at - (walk.box.cell().row(0) * image.shift[0] + walk.box.cell().row(1) * image.shift[1] +
                          walk.box.cell().row(2) * image.shift[2])
                             .transpose();
                for (std::uint32_t b = cells_.start(image.cell); b < cells_.start(image.cell + 1); ++b) {
                    meet(i, order[b], shifted - walk.positions.row(order[b]).transpose());
                }
            }
        }
    }
    flush();
}

void PairSum::add_to(const Box& box, const Array3N& positions, const Charges& charges, std::int64_t* sums,
                     Accumulator& total) {
    Walk walk(box, positions, charges, total);
    visit(walk, [&](std::uint32_t i, std::uint32_t j, double squared, const Vector3& d, const Value& value,
                    Accumulator& own) {
        const double product = charges.charge[i] * charges.charge[j];
        const double factor = product * value.factor;
        if (!std::isfinite(factor) || !std::isfinite(product * value.energy)) {
            own.fail(i, j, std::sqrt(squared));
            return;
        }
        own.add_force(factor * d, sums + 3 * std::size_t{i}, sums + 3 * std::size_t{j});
        if (own.request().observe) {
            own.add_energy(product * value.energy, factor, d);
        }
    });
}

void PairSum::add_curvature(const Box& box, const Array3N& positions, const Charges& charges, Accumulator& total) {
    Walk walk(box, positions, charges, total);
    visit(walk, [&](std::uint32_t i, std::uint32_t j, double squared, const Vector3& /*d*/, const Value& /*value*/,
                    Accumulator& own) {
        if (i == j) {
            return;  // a bead and its own image move together
        }
        const int mobile = (charges.frozen[i] == 0 ? 1 : 0) + (charges.frozen[j] == 0 ? 1 : 0);
        const double curvature = mobile * charges.charge[i] * charges.charge[j] * kernel_.laplacian(std::sqrt(squared));
        if (std::isfinite(curvature)) {
            own.add_energy(curvature, 0.0, Vector3::Zero());
        } else {
            own.fail(i, j, std::sqrt(squared));
        }
    });
}

}  // namespace dlpoly::charge
