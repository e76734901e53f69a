// Dissolved species between beads (see species_exchange.hpp).
#include "meso/species_exchange.hpp"

#include <algorithm>
#include <cmath>

#include "core/normal.hpp"
#include "core/random.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

// Tells the random words of the dissolved species of one pair apart; images take 0 … 215.
constexpr std::uint32_t species_salt = 1000;
constexpr std::uint64_t species_key = 0x9E3779B97F4A7C15U;
constexpr double most_noise = 5.0;         // of LAMMPS' normal numbers
constexpr double gentle_limit = 1.0 / 16;  // of the series below

// 1 − exp(−x). The series is exact to the last bit or two up to the limit, and without a branch.
template <bool gentle>
double lost_part(double x) {
    if constexpr (gentle) {
        double rest = 1.0 - x * (1.0 / 8.0);
        for (const double part : {1.0 / 7.0, 1.0 / 6.0, 1.0 / 5.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 2.0}) {
            rest = 1.0 - x * part * rest;
        }
        return x * rest;
    } else {
        return -std::expm1(-x);
    }
}

}  // namespace

SpeciesExchange::SpeciesExchange(std::int32_t bead_species, std::int32_t dissolved)
    : count_(static_cast<std::size_t>(dissolved)),
      bead_species_(static_cast<std::size_t>(bead_species)),
      flux_(bead_species_ * bead_species_ * count_),
      kind_(flux_.size(), Kind::free),
      held_(bead_species_ * count_, 0) {}

void SpeciesExchange::set_flux(std::int32_t a, std::int32_t b, std::int32_t dissolved, const SpeciesFlux& flux) {
    const auto species = static_cast<std::int32_t>(bead_species_);
    flux_[place(a * species + b, dissolved)] = flux;
    flux_[place(b * species + a, dissolved)] = flux;
    quadratic_ = quadratic_ && flux.exponent == 2.0;
    largest_rate_ = std::max(largest_rate_, flux.rate);
    rows_.reset();
}

void SpeciesExchange::set_held(std::int32_t bead_species, std::int32_t dissolved) {
    held_[place(bead_species, dissolved)] = 1;
    any_held_ = true;
    const auto species = static_cast<std::int32_t>(bead_species_);
    for (std::int32_t a = 0; a < species; ++a) {
        for (std::int32_t b = 0; b < species; ++b) {
            const bool first = is_held(a, dissolved);
            const bool second = is_held(b, dissolved);
            kind_[place(a * species + b, dissolved)] = first && second ? Kind::both_held
                                                       : first         ? Kind::first_held
                                                       : second        ? Kind::second_held
                                                                       : Kind::free;
        }
    }
}

void SpeciesExchange::prepare(const PairTable& table) {
    if (rows_) {
        return;
    }
    std::vector<double> reach(bead_species_ * bead_species_, 0.0);
    for (std::size_t term = 0; term < reach.size(); ++term) {
        for (std::size_t s = 0; s < count_; ++s) {
            const SpeciesFlux& flux = flux_[term * count_ + s];
            if (flux.rate > 0.0 || flux.noise > 0.0) {
                reach[term] = std::max(reach[term], flux.range);
            }
        }
    }
    rows_.emplace(table, none_, std::move(reach), PairRows::Frozen::keep_pairs);
}

template <bool quadratic, bool gentle>
void SpeciesExchange::make_losses(const Row& row, Maps& maps, double duration) const {
    const auto loss = [duration](const SpeciesFlux& flux, Kind kind, double distance) {
        const double closeness = std::max(0.0, 1.0 - distance / flux.range);
        const double weight = quadratic ? closeness * closeness : std::pow(closeness, flux.exponent);
        // A held bead does not come towards the other one: the difference shrinks half as fast.
        const double both = kind == Kind::free ? 2.0 : 1.0;
        return lost_part<gentle>(both * flux.rate * weight * duration);
    };
    const std::size_t pairs = row.size();
    const double* distance = maps.distance.data();
    for (std::size_t s = 0; s < count_; ++s) {
        double* lost = &maps.lost[s * pairs];
        if (bead_species_ == 1) {  // the same numbers for all pairs: the loop vectorises
            const SpeciesFlux flux = flux_[s];
            const Kind kind = kind_[s];
            for (std::size_t k = 0; k < pairs; ++k) {
                lost[k] = loss(flux, kind, distance[k]);
            }
            continue;
        }
        for (std::size_t k = 0; k < pairs; ++k) {
            const std::size_t entry = row.term[k] * count_ + s;
            lost[k] = loss(flux_[entry], kind_[entry], distance[k]);
        }
    }
}

double SpeciesExchange::strong_normal(const Row& row, std::size_t k, std::size_t s, const Draws& draws) const {
    const std::vector<std::uint32_t>& order = rows_->order();
    const auto [low, high] = std::minmax(order[row.i[k]], order[row.j[k]]);
    return gaussian(draw(draws.seed + s * species_key, Stream::species_noise, draws.step, low, high, row.image[k]));
}

// The random part over f(S), of one bead: half of the difference's where both change.
void SpeciesExchange::make_noise(const Row& row, Maps& maps, const Draws& draws) const {
    const std::size_t pairs = row.size();
    const std::uint32_t* order = rows_->order().data();
    const NormalTable& normal = normal_table();
    const double most = noise_ == FluxNoise::linear ? most_noise : HUGE_VAL;
    for (std::size_t s = 0; s < count_; ++s) {
        const std::uint32_t salt = static_cast<std::uint32_t>(s) * species_salt;
        for (std::size_t k = 0; k < pairs; ++k) {
            const std::size_t entry = row.term[k] * count_ + s;
            const SpeciesFlux& one = flux_[entry];
            const double closeness = 1.0 - maps.distance[k] / one.range;
            double& noise = maps.noise[s * pairs + k];
            if (one.noise == 0.0 || !(closeness > 0.0)) {
                noise = 0.0;
                continue;
            }
            const double lost = maps.lost[s * pairs + k];
            const double freedom = kind_[entry] == Kind::free ? 4.0 : 2.0;
            const double squared = one.rate > 0.0 ? lost * (2.0 - lost) / (freedom * one.rate)
                                                  : std::pow(closeness, one.exponent) * draws.duration;
            const std::uint32_t i = row.i[k];
            const std::uint32_t j = row.j[k];
            const double value = draws.strong ? strong_normal(row, k, s, draws)
                                              : normal(mix_words(word_[i], word_[j], salt + row.image[k]));
            const double size = one.noise * std::sqrt(squared) * std::clamp(value, -most, most);
            noise = order[i] < order[j] ? size : -size;  // the bead of the smaller id gains
        }
    }
}

void SpeciesExchange::make_maps(const Row& row, Maps& maps, const Draws& draws) const {
    const std::size_t pairs = row.size();
    maps.distance.resize(pairs);
    maps.lost.resize(pairs * count_);
    for (std::size_t k = 0; k < pairs; ++k) {
        maps.distance[k] = std::sqrt(row.squared[k]);
    }
    const bool gentle = 2.0 * largest_rate_ * draws.duration <= gentle_limit;
    if (quadratic_) {
        gentle ? make_losses<true, true>(row, maps, draws.duration)
               : make_losses<true, false>(row, maps, draws.duration);
    } else {
        gentle ? make_losses<false, true>(row, maps, draws.duration)
               : make_losses<false, false>(row, maps, draws.duration);
    }
    if (noise_ != FluxNoise::none) {
        maps.noise.resize(pairs * count_);
        make_noise(row, maps, draws);
    }
}

template <FluxNoise noise, bool holds>
void SpeciesExchange::use_maps(const Row& row, const Maps& maps, bool backward, double* outflow) {
    const std::size_t pairs = row.size();
    for (std::size_t turn = 0; turn < pairs; ++turn) {
        const std::size_t k = backward ? pairs - 1 - turn : turn;
        double* a = &amount_[row.i[k] * count_];
        double* b = &amount_[row.j[k] * count_];
        for (std::size_t s = 0; s < count_; ++s) {
            const double lost = maps.lost[s * pairs + k];
            if constexpr (holds) {
                const Kind kind = kind_[row.term[k] * count_ + s];
                if (kind == Kind::both_held) {
                    continue;
                }
                if (kind != Kind::free) {
                    double& free = kind == Kind::first_held ? b[s] : a[s];
                    const double held = kind == Kind::first_held ? a[s] : b[s];
                    double moved = lost * (held - free);
                    double left = free + moved;
                    if constexpr (noise != FluxNoise::none) {
                        const double total = held + left;
                        const double size = noise == FluxNoise::root ? std::sqrt(total) : total;
                        const double random = maps.noise[s * pairs + k] * size;
                        left += std::clamp(kind == Kind::first_held ? -random : random, -left, left);
                    }
                    outflow[s] += left - free;
                    free = left;
                    continue;
                }
            }
            // The same number out of one and into the other: the sum changes by rounding alone.
            const double moved = 0.5 * lost * (a[s] - b[s]);
            double first = a[s] - moved;
            double second = b[s] + moved;
            if constexpr (noise != FluxNoise::none) {
                const double total = a[s] + b[s];
                const double size = noise == FluxNoise::root ? std::sqrt(total) : total;
                const double most = std::min(first, second);
                const double random = std::clamp(maps.noise[s * pairs + k] * size, -most, most);
                first += random;
                second -= random;
            }
            a[s] = first;
            b[s] = second;
        }
    }
}

void SpeciesExchange::use_row(const Row& row, const Maps& maps, bool backward, double* outflow) {
    switch (noise_) {
        case FluxNoise::none:
            any_held_ ? use_maps<FluxNoise::none, true>(row, maps, backward, outflow)
                      : use_maps<FluxNoise::none, false>(row, maps, backward, outflow);
            break;
        case FluxNoise::root:
            any_held_ ? use_maps<FluxNoise::root, true>(row, maps, backward, outflow)
                      : use_maps<FluxNoise::root, false>(row, maps, backward, outflow);
            break;
        case FluxNoise::linear:
            any_held_ ? use_maps<FluxNoise::linear, true>(row, maps, backward, outflow)
                      : use_maps<FluxNoise::linear, false>(row, maps, backward, outflow);
            break;
    }
}

void SpeciesExchange::sweep(State& state, const PairTable& table, const StepSettings& settings, double duration,
                            bool backward, std::vector<double>& outflow) {
    prepare(table);
    Particles& particles = state.particles;
    if (!rows_->any() || particles.count() == 0) {
        return;
    }
    const int threads = PairRows::useful_threads(particles);
    rows_->sort(state.box, particles, threads);
    const std::vector<std::uint32_t>& order = rows_->order();
    const std::size_t beads = order.size();
    double* concentration = particles.concentration.data();
    amount_.resize(beads * count_);
    word_.resize(noise_ == FluxNoise::none ? 0 : beads);
    const auto key = bead_word_key(settings.seed, state.step, Stream::species_noise);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        std::copy_n(&concentration[order[k] * count_], count_, &amount_[k * count_]);
        if (!word_.empty()) {
            word_[k] = bead_word(order[k], key.data());
        }
    }
    const Draws draws{duration, settings.seed, state.step, settings.precision == Precision::reference};
    std::vector<double> flowed(any_held_ ? rows_->count() * count_ : count_);
    maps_.resize(static_cast<std::size_t>(threads));
    rows_->visit(backward, threads, [&](const Row& row, std::size_t where, std::size_t thread) {
        if (row.size() == 0) {
            return;
        }
        make_maps(row, maps_[thread], draws);
        use_row(row, maps_[thread], backward, any_held_ ? &flowed[where * count_] : nullptr);
    });
    for (std::size_t n = 0; n < flowed.size(); ++n) {  // in one order, whatever thread made them
        outflow[n % count_] += flowed[n];
    }
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        std::copy_n(&amount_[k * count_], count_, &concentration[order[k] * count_]);
    }
}

}  // namespace dlpoly
