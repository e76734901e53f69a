// Histogram of pair distances (see pair_distances.hpp).
#include "observe/pair_distances.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/threads.hpp"

namespace dlpoly {

PairDistances::PairDistances(std::int32_t species, double range, std::int32_t bins)
    : species_(species), range_(range), bins_(bins) {
    if (!(range > 0.0) || bins < 1) {
        throw std::invalid_argument("the pair distance histogram needs a range larger than 0 and at least one bin");
    }
    counts_.assign(static_cast<std::size_t>(species) * static_cast<std::size_t>(species * bins), 0);
}

void PairDistances::restore(std::vector<std::int64_t> counts, std::int64_t samples, double volumes) {
    if (counts.size() != counts_.size()) {
        throw std::invalid_argument("the stored pair distance histogram has another number of species or bins");
    }
    counts_ = std::move(counts);
    samples_ = samples;
    volumes_ = volumes;
}

void PairDistances::sample(const Box& box, const Particles& particles) {
    cells_.build(box, particles.position, range_);
    const std::vector<std::uint32_t>& order = cells_.order();
    const double per_bin = bins_ / range_;
    std::vector<std::vector<std::int64_t>> partial(static_cast<std::size_t>(thread_limit()));
#ifdef _OPENMP
#pragma omp parallel
#endif
    {
        std::vector<std::int64_t>& counts = partial[static_cast<std::size_t>(thread_number())];
        counts.assign(counts_.size(), 0);
        std::vector<CellImage> neighbours;
        const auto visit = [&](std::uint32_t i, std::uint32_t j, const Vector3& shift) {
            const auto a = static_cast<Eigen::Index>(order[i]);
            const auto b = static_cast<Eigen::Index>(order[j]);
            const Vector3 d = (particles.position.row(a) - particles.position.row(b)).transpose() - shift;
            const double distance = d.norm();
            if (distance < range_) {
                const auto [low, high] = std::minmax(particles.species[order[i]], particles.species[order[j]]);
                const auto bin = std::min(static_cast<std::int32_t>(distance * per_bin), bins_ - 1);
                ++counts[static_cast<std::size_t>((low * species_ + high) * bins_ + bin)];
            }
        };
        const std::int32_t cells = cells_.cell_count();
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 64)
#endif
        for (std::int32_t cell = 0; cell < cells; ++cell) {
            for (std::uint32_t i = cells_.start(cell); i < cells_.start(cell + 1); ++i) {
                for (std::uint32_t j = i + 1; j < cells_.start(cell + 1); ++j) {
                    visit(i, j, Vector3::Zero());
                }
            }
            cells_.neighbours(cell, neighbours);
            for (const CellImage& other : neighbours) {
                const Vector3 shift = (box.cell().row(0) * other.shift[0] + box.cell().row(1) * other.shift[1] +
                                       box.cell().row(2) * other.shift[2])
                                          .transpose();
                for (std::uint32_t i = cells_.start(cell); i < cells_.start(cell + 1); ++i) {
                    for (std::uint32_t j = cells_.start(other.cell); j < cells_.start(other.cell + 1); ++j) {
                        visit(i, j, shift);
                    }
                }
            }
        }
    }
    for (const std::vector<std::int64_t>& counts : partial) {
        for (std::size_t k = 0; k < counts.size(); ++k) {
            counts_[k] += counts[k];
        }
    }
    ++samples_;
    volumes_ += box.volume();
}

}  // namespace dlpoly
