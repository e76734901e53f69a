// The gradients of local densities (see density_gradients.hpp).
#include "meso/density_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "meso/many_body.hpp"

namespace dlpoly {

namespace {

constexpr int slope_bits = 45;  // 2^18 neighbours fit 64 bits

double squared(const std::array<std::int64_t, 3>& vector, double unit) {
    double sum = 0.0;
    for (const std::int64_t component : vector) {
        const double value = static_cast<double>(component) * unit;
        sum += value * value;
    }
    return sum;
}

}  // namespace

DensityGradients::DensityGradients(const std::vector<DensityPair>& pairs, const std::vector<double>& second,
                                   const std::vector<std::uint8_t>& mobile, int threads)
    : pairs_(pairs),
      second_(second),
      mobile_(mobile),
      own_(second.size(), std::array<std::int64_t, 3>{}),
      slopes_(static_cast<std::size_t>(threads)) {
    double steepest = 0.0;
    for (const DensityPair& pair : pairs_) {
        steepest = std::max(steepest, pair.range > 0.0 ? pair.exponent * pair.height / pair.range : 0.0);
    }
    scale_ = std::ldexp(1.0, slope_bits - static_cast<int>(std::ceil(std::log2(steepest))));
}

double DensityGradients::reach_squared(std::uint32_t term, double /*of_table*/) const {
    return pairs_[term].range * pairs_[term].range;
}

void DensityGradients::visit(const PairBatch& batch, const double* /*factors*/, const std::uint32_t* /*order*/,
                             int thread) {
    const DensityPair& pair = pairs_[batch.term];
    std::vector<Slope>& slopes = slopes_[static_cast<std::size_t>(thread)];
    for (std::size_t k = 0; k < batch.size; ++k) {
        const std::uint32_t i = batch.i.values[k];
        const std::uint32_t j = batch.j.values[k];
        const double distance = std::sqrt(batch.distance_squared.values[k]);
        if (i == j || distance == 0.0) {
            continue;  // a bead and its own image move together; coincident beads lack a direction
        }
        const double slope = pair.exponent * pair.height / pair.range *
                             std::pow(std::max(0.0, 1.0 - distance / pair.range), pair.exponent - 1.0);
        const std::array<double, 3> d{batch.dx.values[k], batch.dy.values[k], batch.dz.values[k]};
        Slope found{std::min(i, j), std::max(i, j), {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t component = std::llrint(slope * d[axis] / distance * scale_);
            own_[i][axis] += component;
            own_[j][axis] -= component;
            found.vector[axis] = i < j ? component : -component;
        }
        slopes.push_back(found);
    }
}

double DensityGradients::sum(const std::vector<std::uint32_t>& order) {
    // Images of one bead move together: their vectors are added before they are squared.
    std::vector<Slope> all;
    for (const std::vector<Slope>& slopes : slopes_) {
        all.insert(all.end(), slopes.begin(), slopes.end());
    }
    // By ids, so that the order of the sum follows from nothing else; images of one pair in any order, being integers.
    const auto ids = [&order](const Slope& one) { return std::minmax(order[one.i], order[one.j]); };
    std::ranges::sort(all, [&ids](const Slope& a, const Slope& b) { return ids(a) < ids(b); });
    const double unit = 1.0 / scale_;
    double total = 0.0;
    for (std::size_t begin = 0; begin < all.size();) {
        const Slope& first = all[begin];
        std::array<std::int64_t, 3> vector{};
        for (; begin < all.size() && all[begin].i == first.i && all[begin].j == first.j; ++begin) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                vector[axis] += all[begin].vector[axis];
            }
        }
        const double weight =
            (mobile_[first.j] != 0 ? second_[first.i] : 0.0) + (mobile_[first.i] != 0 ? second_[first.j] : 0.0);
        total += weight * squared(vector, unit);
    }
    std::vector<double> by_id(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
        by_id[order[k]] = mobile_[k] != 0 ? second_[k] * squared(own_[k], unit) : 0.0;
    }
    for (const double one : by_id) {
        total += one;
    }
    return total;
}

}  // namespace dlpoly
