// Excluded and scaled pairs of charges (see special_pairs.hpp).
#include "charge/special_pairs.hpp"

#include <cmath>

#include "bonded/geometry.hpp"

namespace dlpoly::charge {

namespace {

constexpr std::int64_t worth_threads = 2000;

}  // namespace

SpecialPairs::SpecialPairs(std::size_t charges, std::vector<Pair> pairs, std::optional<Screening> screening,
                           const Kernel& kernel, double range)
    : pairs_(std::move(pairs)), start_(charges + 1, 0), screening_(screening), kernel_(kernel), range_(range) {
    for (const Pair& pair : pairs_) {
        ++start_[pair.i + 1];
        ++start_[pair.j + 1];
    }
    for (std::size_t i = 0; i < charges; ++i) {
        start_[i + 1] += start_[i];
    }
    touching_.resize(2 * pairs_.size());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        touching_[next[pairs_[k].i]++] = k;
        touching_[next[pairs_[k].j]++] = k;
    }
}

// Each charge looks at all of its pairs, so that no two threads write to one sum; opposite forces round oppositely.
void SpecialPairs::add_to(const Box& box, const Array3N& positions, const Charges& charges, std::int64_t* sums,
                          Accumulator& total) const {
    const bonded::MinimumImage image(box);
    const auto count = static_cast<std::int64_t>(charges.size());
    const bool parallel = count >= worth_threads;
#ifdef _OPENMP
#pragma omp parallel if (parallel)
#endif
    {
        Accumulator own(total.request());
#ifdef _OPENMP
#pragma omp for schedule(static)
#endif
        for (std::int64_t c = 0; c < count; ++c) {
            const auto i = static_cast<std::uint32_t>(c);
            for (std::size_t at = start_[i]; at < start_[i + 1]; ++at) {
                const Pair& pair = pairs_[touching_[at]];
                Vector3 d = (positions.row(pair.i) - positions.row(pair.j)).transpose();
                static_cast<void>(image.shorten(d));
                const double r = d.norm();
                const double product = charges.charge[pair.i] * charges.charge[pair.j];
                Value value{0.0, 0.0};
                if (pair.scale != 0.0 && r < range_) {
                    const Value bare = kernel_.at(r);
                    value = {pair.scale * bare.energy, pair.scale * bare.factor};
                }
                if (pair.excluded && screening_) {
                    const Value taken = (*screening_)(r);
                    value = {value.energy - taken.energy, value.factor - taken.factor};
                }
                const double factor = product * value.factor;
                if (!std::isfinite(factor) || !std::isfinite(product * value.energy)) {
                    own.fail(pair.i, pair.j, r);
                    continue;
                }
                own.add_force((i == pair.i ? factor : -factor) * d, sums + 3 * std::size_t{i}, nullptr);
                if (own.request().observe && i == pair.i) {
                    own.add_energy(product * value.energy, factor, d);
                }
            }
        }
#ifdef _OPENMP
#pragma omp critical
#endif
        total.add(own);
    }
}

void SpecialPairs::add_curvature(const Box& box, const Array3N& positions, const Charges& charges,
                                 Accumulator& total) const {
    const bonded::MinimumImage image(box);
    for (const Pair& pair : pairs_) {
        Vector3 d = (positions.row(pair.i) - positions.row(pair.j)).transpose();
        static_cast<void>(image.shorten(d));
        const double r = d.norm();
        double curvature = pair.scale != 0.0 && r < range_ ? pair.scale * kernel_.laplacian(r) : 0.0;
        if (pair.excluded && screening_) {
            // ∇² erf(αr)/r = −(4α³/√π) e^(−α²r²)
            const double alpha = screening_->alpha();
            curvature += 4.0 * alpha * alpha * alpha / std::sqrt(pi) * std::exp(-alpha * alpha * r * r);
        }
        const int mobile = (charges.frozen[pair.i] == 0 ? 1 : 0) + (charges.frozen[pair.j] == 0 ? 1 : 0);
        curvature *= mobile * charges.charge[pair.i] * charges.charge[pair.j];
        if (std::isfinite(curvature)) {
            total.add_energy(curvature, 0.0, Vector3::Zero());
        } else {
            total.fail(pair.i, pair.j, r);
        }
    }
}

}  // namespace dlpoly::charge
