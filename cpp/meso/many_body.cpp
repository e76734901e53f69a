// Many-body DPD (see many_body.hpp).
#include "meso/many_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/types.hpp"
#include "meso/density_gradients.hpp"

namespace dlpoly {

namespace {

// Densities are sums of terms below 2^47, so that 2^16 neighbours at contact fit 64 bits; a list of as many beads on
// one spot would not fit a computer.
constexpr int density_bits = 47;

std::size_t whole_lanes(std::size_t count) { return (count + batch_lanes - 1) / batch_lanes * batch_lanes; }

// Adds what every pair is to the densities of its beads.
class DensityVisitor final : public PairVisitor {
  public:
    DensityVisitor(const ManyBodySettings& settings, const ManyBodyLoops& loops, double scale,
                   std::vector<std::int64_t>& sums)
        : settings_(settings), loops_(loops), scale_(scale), sums_(sums) {}

    [[nodiscard]] bool wants_factors() const override { return false; }

    [[nodiscard]] double reach_squared(std::uint32_t term, double /*of_table*/) const override {
        const double range = settings_.pairs[term].range;
        return range * range;
    }

    void visit(const PairBatch& batch, const double* /*factors*/, const std::uint32_t* /*order*/,
               int /*thread*/) override {
        const DensityPair& pair = settings_.pairs[batch.term];
        alignas(64) std::array<std::int64_t, batch_capacity + batch_lanes> weights;
        const DensityLoop loop{
            batch.distance_squared.values, weights.data(), whole_lanes(batch.size), 1.0 / pair.range, pair.exponent,
            pair.height * scale_};
        (settings_.kernel == DensityKernel::lucy ? loops_.lucy_density
         : pair.exponent == 2.0                  ? loops_.quadratic_density
                                                 : loops_.power_density)(loop);
        for (std::size_t r = 0; r < batch.runs; ++r) {
            const PairRun run = batch.run.values[r];
            std::int64_t own = 0;
            for (std::uint32_t k = run.begin; k < run.end; ++k) {
                own += weights[k];
                sums_[batch.j.values[k]] += weights[k];
            }
            sums_[run.bead] += own;
        }
    }

  private:
    const ManyBodySettings& settings_;
    const ManyBodyLoops& loops_;
    double scale_;
    std::vector<std::int64_t>& sums_;  // in sorted order
};

void require(bool holds, const char* message) {
    if (!holds) {
        throw std::invalid_argument(message);
    }
}

}  // namespace

ManyBody::ManyBody(ManyBodySettings settings) : settings_(std::move(settings)), loops_(&many_body_loops()) {
    double highest = 0.0;
    for (const DensityPair& pair : settings_.pairs) {
        require(std::isfinite(pair.height) && pair.height >= 0.0 && std::isfinite(pair.push) && pair.push >= 0.0 &&
                    std::isfinite(pair.range) && pair.range >= 0.0 && pair.exponent >= 2.0,
                "a pair of local densities needs finite numbers and an exponent of 2 or more");
        highest = std::max(highest, pair.range > 0.0 ? pair.height : 0.0);
    }
    require(std::isfinite(settings_.strength) && settings_.strength >= 0.0, "the strength must be 0 or more");
    require(settings_.pairs.size() == settings_.powers.size() * settings_.powers.size(), "one power m a species");
    for (const double power : settings_.powers) {
        require(std::isfinite(power) && power >= 1.0, "the power m of a species must be 1 or more");
    }
    require(highest > 0.0, "no pair adds to local densities");
    exponent_ = density_bits - static_cast<int>(std::ceil(std::log2(highest)));
}

double ManyBody::energy_at(double density, std::int32_t species) const {
    const double power = settings_.powers[static_cast<std::size_t>(species)];
    return settings_.strength * (power == 2.0 ? density * density : std::pow(density, power)) / power;
}

double ManyBody::slope_at(double density, std::int32_t species) const {
    const double power = settings_.powers[static_cast<std::size_t>(species)];
    return settings_.strength * (power == 2.0 ? density : std::pow(density, power - 1.0));
}

double ManyBody::second_slope_at(double density, std::int32_t species) const {
    const double power = settings_.powers[static_cast<std::size_t>(species)];
    if (power == 1.0 || power == 2.0) {
        return (power - 1.0) * settings_.strength;
    }
    return density > 0.0 ? (power - 1.0) * settings_.strength * std::pow(density, power - 2.0) : 0.0;
}

void ManyBody::prepare(PairForces& pairs, const Box& box, const Particles& particles, int threads) {
    threads_ = threads;
    order_ = pairs.order();
    const std::size_t beads = order_.size();
    sums_.assign(beads, 0);
    densities_.resize(beads);
    responses_.resize(beads);
    species_.resize(beads);
    DensityVisitor visitor(settings_, *loops_, std::ldexp(1.0, exponent_), sums_);
    pairs.show(visitor, threads);
    if (std::ranges::any_of(particles.frozen, [](std::uint8_t frozen) { return frozen != 0; })) {
        add_frozen(box, particles);
    }
    const double unit = std::ldexp(1.0, -exponent_);
    const bool lucy = settings_.kernel == DensityKernel::lucy;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        species_[k] = particles.species[order_[k]];
        densities_[k] = static_cast<double>(sums_[k]) * unit;
        responses_[k] = lucy ? densities_[k] : slope_at(densities_[k], species_[k]);
    }
}

void ManyBody::add_frozen(const Box& box, const Particles& particles) {
    find_frozen_densities(box, particles);
    std::vector<std::int64_t> by_id(order_.size(), 0);
    for (std::size_t k = 0; k < frozen_.size(); ++k) {
        by_id[frozen_[k]] = frozen_sums_[k];
    }
    for (std::size_t k = 0; k < order_.size(); ++k) {
        sums_[k] += by_id[order_[k]];
    }
}

// What frozen beads are to each other's densities, where they or the cell have changed. They are the beads of a pair
// loop of their own, in which they may move.
void ManyBody::find_frozen_densities(const Box& box, const Particles& particles) {
    std::vector<std::uint32_t> ids;
    for (std::size_t i = 0; i < particles.frozen.size(); ++i) {
        if (particles.frozen[i] != 0) {
            ids.push_back(static_cast<std::uint32_t>(i));
        }
    }
    Particles alone;
    alone.position.resize(static_cast<Eigen::Index>(ids.size()), 3);
    for (std::size_t k = 0; k < ids.size(); ++k) {
        alone.position.row(static_cast<Eigen::Index>(k)) = particles.position.row(static_cast<Eigen::Index>(ids[k]));
        alone.species.push_back(particles.species[ids[k]]);
    }
    if (ids == frozen_ && box.cell() == frozen_cell_ && alone.position == frozen_positions_) {
        return;
    }
    alone.frozen.assign(ids.size(), 0);
    const auto species = static_cast<std::int32_t>(settings_.powers.size());
    PairTable table(species);
    for (std::int32_t a = 0; a < species; ++a) {
        for (std::int32_t b = 0; b <= a; ++b) {
            table.set_drag(a, b, {1.0, 0.0, settings_.pairs[table.term(a, b)].range});
        }
    }
    PairForces pairs(std::move(table), 1.0, 1.0);
    std::vector<std::int64_t> sums(ids.size(), 0);
    DensityVisitor visitor(settings_, *loops_, std::ldexp(1.0, exponent_), sums);
    pairs.visit(box, alone, visitor);
    frozen_sums_.assign(ids.size(), 0);
    frozen_energy_ = 0.0;
    for (std::size_t k = 0; k < pairs.order().size(); ++k) {
        frozen_sums_[pairs.order()[k]] = sums[k];
    }
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const double density = std::ldexp(static_cast<double>(frozen_sums_[k]), -exponent_);
        frozen_energy_ += energy_at(density, alone.species[k]);
    }
    frozen_ = std::move(ids);
    frozen_positions_ = alone.position;
    frozen_cell_ = box.cell();
}

void ManyBody::change_conservative(const PairBatch& batch, BatchResult& result) const {
    const DensityPair& pair = settings_.pairs[batch.term];
    if (!(pair.range > 0.0)) {
        return;
    }
    const RepulsionLoop loop{
        batch.distance_squared.values, batch.i.values,   batch.j.values, responses_.data(), result.conservative.values,
        whole_lanes(batch.size),       1.0 / pair.range, pair.exponent,  pair.push};
    (pair.exponent == 2.0 ? loops_->linear_repulsion : loops_->power_repulsion)(loop);
}

double ManyBody::energy() const {
    if (settings_.kernel == DensityKernel::lucy) {
        return 0.0;
    }
    std::vector<double> by_id(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
        by_id[order_[k]] = energy_at(densities_[k], species_[k]);
    }
    double sum = -frozen_energy_;
    for (const double energy : by_id) {  // in the order of the ids, whatever the cells are
        sum += energy;
    }
    return sum;
}

void ManyBody::change_curvature(const PairBatch& batch, double* curvature) const {
    const DensityPair& pair = settings_.pairs[batch.term];
    if (!(pair.range > 0.0)) {
        return;
    }
    for (std::size_t k = 0; k < batch.size; ++k) {
        const double distance = std::sqrt(batch.distance_squared.values[k]);
        if (settings_.kernel == DensityKernel::lucy) {
            curvature[k] = std::numeric_limits<double>::quiet_NaN();
            continue;
        }
        if (!(distance < pair.range) || distance == 0.0) {
            continue;
        }
        const double both = responses_[batch.i.values[k]] + responses_[batch.j.values[k]];
        const double near = 1.0 - distance / pair.range;
        // (ψ'_i + ψ'_j)(W'' + 2W'/r) with W' = −push (1 − r/r_d)^(n − 1)
        const double second = (pair.exponent - 1.0) / pair.range * std::pow(near, pair.exponent - 2.0);
        curvature[k] += pair.push * both * (second - 2.0 * std::pow(near, pair.exponent - 1.0) / distance);
    }
}

// Σ ψ''_i |∇_k ρ̄_i|² over all beads i and all mobile beads k.
double ManyBody::curvature(PairForces& pairs, const Box& /*box*/, const Particles& particles) {
    if (settings_.kernel == DensityKernel::lucy) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<double> second(order_.size());
    std::vector<std::uint8_t> mobile(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
        second[k] = second_slope_at(densities_[k], species_[k]);
        mobile[k] = particles.frozen[order_[k]] == 0 ? 1 : 0;
    }
    DensityGradients gradients(settings_.pairs, second, mobile, threads_);
    pairs.show(gradients, threads_);
    return gradients.sum(order_);
}

double ManyBody::characteristic_force() const {
    double largest = 0.0;
    for (const DensityPair& pair : settings_.pairs) {
        // Four beads in a cube of r_d, counted as the kernel counts them: about that of a liquid.
        const double n = pair.exponent;
        const double density = 32.0 * pi / ((n + 1.0) * (n + 2.0) * (n + 3.0)) * pair.height;
        for (std::size_t species = 0; species < settings_.powers.size(); ++species) {
            const double response = settings_.kernel == DensityKernel::lucy
                                        ? density
                                        : slope_at(density, static_cast<std::int32_t>(species));
            largest = std::max(largest, 2.0 * pair.push * response);
        }
    }
    return std::isfinite(largest) ? largest : 0.0;
}

std::vector<double> ManyBody::local_densities() const {
    std::vector<double> by_id(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
        by_id[order_[k]] = densities_[k];
    }
    return by_id;
}

}  // namespace dlpoly
