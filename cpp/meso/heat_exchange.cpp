// Heat between neighbours (see heat_exchange.hpp).
#include "meso/heat_exchange.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/failure.hpp"
#include "core/normal.hpp"
#include "core/random.hpp"
#include "forces/pair_batch.hpp"

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
    : pairs_(std::move(pairs)),
      loops_(&heat_exchange_loops()),
      rows_(table, none_, ranges(*pairs_), PairRows::Frozen::keep_pairs),
      one_term_(pairs_->all().size() == 1) {
    for (const HeatPair& pair : pairs_->all()) {
        quadratic_ = quadratic_ && (pair.exponent == 2.0 || !(pair.conductivity > 0.0));
    }
}

void HeatExchange::gather(const State& state, const StepSettings& settings, [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    const Particles& particles = state.particles;
    const auto key = bead_word_key(settings.seed, state.step, Stream::heat_noise);
    temperature_.resize(beads);
    capacity_.resize(beads);
    inverse_capacity_.resize(beads);
    gained_.assign(beads, 0.0);
    word_.resize(beads);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const std::uint32_t id = order[k];
        const double capacity = particles.heat_capacity[id];
        temperature_[k] = particles.temperature[id];
        capacity_[k] = capacity;
        inverse_capacity_[k] = pairs_->held[id] != 0 ? 0.0 : 1.0 / capacity;
        word_[k] = bead_word(id, key.data());
    }
}

void HeatExchange::spread(State& state, [[maybe_unused]] int threads) const {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    double gained = 0.0;  // in one order
    for (std::size_t k = 0; k < beads; ++k) {
        if (!std::isfinite(temperature_[k]) || !std::isfinite(gained_[k])) {
            throw RunFailure("step " + std::to_string(state.step) + ": the internal temperature of bead " +
                             std::to_string(order[k] + 1) + " is not a number");
        }
        gained += gained_[k];
    }
    state.heat_supplied -= gained;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        state.particles.temperature[order[k]] = temperature_[k];
    }
}

void HeatExchange::arrange(const PairRows::Row& row, Turns& turns) const {
    const std::size_t pairs = row.size();
    turns.rounds.arrange(row, temperature_.size());
    // Loops over whole lanes also read what follows the last pair.
    const std::size_t room = pairs + batch_lanes;
    for (auto* array : {&turns.first, &turns.second, &turns.term, &turns.image}) {
        array->resize(room);
    }
    turns.word.resize(room);
    for (auto* array : {&turns.squared, &turns.weight, &turns.normal}) {
        array->resize(room);
    }
    const auto put = [&](std::size_t place, std::size_t k) {
        turns.first[place] = row.i[k];
        turns.second[place] = row.j[k];
        turns.squared[place] = row.squared[k];
        if (!one_term_) {
            turns.term[place] = row.term[k];
        }
        if (rows_.has_images()) {
            turns.image[place] = row.image[k];
        }
    };
    for (std::size_t k = 0; k < pairs; ++k) {
        put(turns.rounds.place()[k], k);
    }
    for (std::size_t place = pairs; place < room; ++place) {
        put(place, pairs - 1);
    }
}

void HeatExchange::make_normals(Turns& turns, const StepSettings& settings, std::uint64_t step) const {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t pairs = turns.rounds.place().size();
    const auto normal_of = [&](std::size_t k, double value) {
        return order[turns.first[k]] < order[turns.second[k]] ? value : -value;
    };
    if (settings.precision == Precision::reference) {
        for (std::size_t k = 0; k < pairs; ++k) {
            const auto [low, high] = std::minmax(order[turns.first[k]], order[turns.second[k]]);
            const auto image = static_cast<std::uint8_t>(rows_.has_images() ? turns.image[k] : 0);
            turns.normal[k] = normal_of(k, gaussian(draw(settings.seed, Stream::heat_noise, step, low, high, image)));
        }
        return;
    }
    loops_->normals({turns.first.data(), turns.second.data(), rows_.has_images() ? turns.image.data() : nullptr, pairs,
                     word_.data(), order.data(), normal_table().quantiles(), turns.word.data(), turns.normal.data()});
    for (std::size_t k = 0; k < pairs; ++k) {
        if (NormalTable::is_tail(turns.word[k])) {
            turns.normal[k] = normal_of(k, NormalTable::of_tail(turns.word[k]));
        }
    }
}

void HeatExchange::give(std::uint32_t first, std::uint32_t second, double gain) {
    const double energy = capacity_[first] * temperature_[first];
    const double of_other = capacity_[second] * temperature_[second];
    if (inverse_capacity_[second] == 0.0) {
        gain = bounded_gain(energy, gain, infinity);
        gained_[second] -= gain;
    } else if (inverse_capacity_[first] == 0.0) {
        gain = -bounded_gain(of_other, -gain, infinity);
        gained_[first] += gain;
    } else {
        gain = bounded_gain(energy, gain, energy + of_other);
    }
    temperature_[first] += gain * inverse_capacity_[first];
    temperature_[second] -= gain * inverse_capacity_[second];
}

void HeatExchange::exchange(const PairRows::Row& row, Turns& turns, const StepSettings& settings, std::uint64_t step) {
    if (row.size() == 0) {
        return;
    }
    arrange(row, turns);
    const HeatPair* pairs = pairs_->all().data();
    loops_->weights[one_term_ ? 1 : 0][quadratic_ ? 1 : 0](
        {turns.squared.data(), turns.term.data(), row.size(), pairs, settings.timestep, turns.weight.data()});
    make_normals(turns, settings, step);
    const HeatRound round{turns.first.data(),      turns.second.data(), turns.term.data(),
                          turns.weight.data(),     turns.normal.data(), pairs,
                          pairs_->reference(),     temperature_.data(), capacity_.data(),
                          inverse_capacity_.data()};
    std::array<UnusualGain, heat_round_capacity> unusual;
    const std::vector<std::uint32_t>& start = turns.rounds.start();
    for (std::size_t n = 0; n < turns.rounds.count(); ++n) {
        for (std::size_t begin = start[n]; begin < start[n + 1]; begin += heat_round_capacity) {
            const std::size_t end = std::min<std::size_t>(begin + heat_round_capacity, start[n + 1]);
            const std::size_t found = loops_->exchange[one_term_ ? 1 : 0](round, begin, end, unusual.data());
            for (std::size_t m = 0; m < found; ++m) {
                const std::size_t place = unusual[m].place;
                give(turns.first[place], turns.second[place], unusual[m].gain);
            }
        }
    }
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
    turns_.resize(static_cast<std::size_t>(threads));
    rows_.visit(false, threads, [&](const PairRows::Row& row, std::size_t, std::size_t thread) {
        exchange(row, turns_[thread], settings, step);
    });
    spread(state, threads);
}

}  // namespace dlpoly
