// Heat between neighbours (see heat_exchange.hpp).
#include "meso/heat_exchange.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/failure.hpp"
#include "core/normal.hpp"
#include "core/random.hpp"

namespace dlpoly {

namespace {

std::vector<double> ranges(const HeatPairs& pairs) {
    std::vector<double> reach;
    for (const HeatPair& pair : pairs.all()) {
        reach.push_back(pair.conductivity > 0.0 ? pair.range : 0.0);
    }
    return reach;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

// 1 − e^{−x}; the series, which needs no call, is exact to the last bit or two.
double lost_part(double x) noexcept {
    constexpr double gentle = 1.0 / 16;
    if (x > gentle) {
        return -std::expm1(-x);
    }
    double rest = 1.0 - x * (1.0 / 8.0);
    for (const double part : {1.0 / 7.0, 1.0 / 6.0, 1.0 / 5.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 2.0}) {
        rest = 1.0 - x * part * rest;
    }
    return x * rest;
}

// The gain with which an energy stays between 0 and `sum`: reflected at both, and never quite at them.
double bounded_gain(double energy, double gain, double sum) noexcept {
    constexpr double least = 1e-12;
    if (energy + gain > 0.0 && energy + gain < sum) {
        return gain;
    }
    double inside = std::abs(energy + gain);
    if (inside >= sum) {
        inside = std::fmod(inside, 2.0 * sum);
        inside = inside > sum ? 2.0 * sum - inside : inside;
    }
    inside = std::max(inside, least * energy);
    return (std::isfinite(sum) ? std::min(inside, sum - least * (sum - energy)) : inside) - energy;
}

}  // namespace

HeatExchange::HeatExchange(const PairTable& table, std::shared_ptr<const HeatPairs> pairs)
    : pairs_(std::move(pairs)), rows_(table, none_, ranges(*pairs_), PairRows::Frozen::keep_pairs) {}

void HeatExchange::gather(const State& state, const StepSettings& settings, [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    const Particles& particles = state.particles;
    const auto key = bead_word_key(settings.seed, state.step, Stream::heat_noise);
    beads_.resize(beads);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const std::uint32_t id = order[k];
        const double capacity = particles.heat_capacity[id];
        beads_[k] = {particles.temperature[id], capacity, pairs_->held[id] != 0 ? 0.0 : 1.0 / capacity, 0.0,
                     bead_word(id, key.data())};
    }
}

void HeatExchange::spread(State& state, [[maybe_unused]] int threads) const {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    double gained = 0.0;  // in one order
    for (std::size_t k = 0; k < beads; ++k) {
        if (!std::isfinite(beads_[k].temperature) || !std::isfinite(beads_[k].gained)) {
            throw RunFailure("step " + std::to_string(state.step) + ": the internal temperature of bead " +
                             std::to_string(order[k] + 1) + " is not a number");
        }
        gained += beads_[k].gained;
    }
    state.heat_supplied -= gained;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        state.particles.temperature[order[k]] = beads_[k].temperature;
    }
}

double HeatExchange::noise(const PairRows::Row& row, std::size_t k, const StepSettings& settings,
                           std::uint64_t step) const {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::uint32_t first = order[row.i[k]];
    const std::uint32_t second = order[row.j[k]];
    const double normal = settings.precision == Precision::reference
                              ? gaussian(draw(settings.seed, Stream::heat_noise, step, std::min(first, second),
                                              std::max(first, second), row.image[k]))
                              : normal_table()(mix_words(beads_[row.i[k]].word, beads_[row.j[k]].word, row.image[k]));
    return first < second ? normal : -normal;
}

void HeatExchange::exchange(const PairRows::Row& row, std::size_t k, const StepSettings& settings, std::uint64_t step) {
    Bead& a = beads_[row.i[k]];
    Bead& b = beads_[row.j[k]];
    const double inverse = a.inverse_capacity + b.inverse_capacity;
    const HeatPair& pair = pairs_->at(row.term[k]);
    const double mean = 0.5 * (a.temperature + b.temperature);
    const HeatPairs::Conductivity kappa = pairs_->conductivity(row.term[k], mean);
    const double closeness = 1.0 - std::sqrt(row.squared[k]) / pair.range;
    const double weight = pair.exponent == 2.0 ? closeness * closeness : std::pow(closeness, pair.exponent);
    if (inverse == 0.0 || !(kappa.value * weight > 0.0)) {
        return;
    }
    const double step_weight = weight * settings.timestep;
    const double ratio = 0.25 * (a.temperature / b.temperature + 2.0 + b.temperature / a.temperature);
    const double relaxed = a.capacity * b.capacity * inverse * kappa.value * step_weight * ratio;
    const double lost = lost_part(relaxed);
    const double capacity = 1.0 / inverse;
    const double variance = lost * (2.0 - lost) * capacity;  // 1 − e^{−2x}
    const double slope = a.capacity * b.capacity * mean * (2.0 * kappa.value + mean * kappa.slope);
    double gain = lost * (b.temperature - a.temperature) * capacity;
    gain += std::sqrt(variance * a.temperature) * std::sqrt(b.temperature) * noise(row, k, settings, step);
    gain += 0.5 * step_weight * (a.inverse_capacity - b.inverse_capacity) * slope;
    const double energy_a = a.capacity * a.temperature;
    const double energy_b = b.capacity * b.temperature;
    if (b.inverse_capacity == 0.0) {
        gain = bounded_gain(energy_a, gain, infinity);
        b.gained -= gain;
    } else if (a.inverse_capacity == 0.0) {
        gain = -bounded_gain(energy_b, -gain, infinity);
        a.gained += gain;
    } else {
        gain = bounded_gain(energy_a, gain, energy_a + energy_b);
    }
    a.temperature += gain * a.inverse_capacity;
    b.temperature -= gain * b.inverse_capacity;
}

void HeatExchange::advance(State& state, Forces& /*forces*/, const StepSettings& settings) {
    Particles& particles = state.particles;
    if (!rows_.any() || particles.count() == 0) {
        return;
    }
    const int threads = PairRows::useful_threads(particles);
    rows_.sort(state.box, particles, threads);
    gather(state, settings, threads);
    const std::uint64_t step = state.step;
    rows_.visit(false, threads, [&](const PairRows::Row& row, std::size_t, std::size_t) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            exchange(row, k, settings, step);
        }
    });
    spread(state, threads);
}

}  // namespace dlpoly
