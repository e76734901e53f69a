// Sweeps over pairs (see pair_sweep.hpp).
#include "sweep/pair_sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/failure.hpp"
#include "core/normal.hpp"
#include "core/threads.hpp"
#include "sweep/common_drag.hpp"
#include "sweep/implicit_euler.hpp"
#include "sweep/lowe_andersen.hpp"
#include "sweep/ornstein_uhlenbeck.hpp"
#include "sweep/peters_first.hpp"
#include "sweep/shardlow.hpp"
#include "sweep/stoyanov_groot.hpp"

namespace dlpoly {

using sweep::PairDraw;
using sweep::PairSituation;

namespace {

// Numbers that tell the random words of one pair apart; images take 0 … 215.
constexpr std::uint32_t uniform_salt = 1000;
constexpr std::uint32_t across_salt = 2000;

// The ranges of the drags, by term.
std::vector<double> reaches(const PairTable& table) {
    std::vector<double> reach;
    for (const PairDrag& drag : table.drags()) {
        reach.push_back(drag.drag > 0.0 ? drag.cutoff : 0.0);
    }
    return reach;
}

}  // namespace

PairSweep::PairSweep(const PairTable& table, const Exclusions& exclusions)
    : table_(table), rows_(table, exclusions, reaches(table), PairRows::Frozen::skip_pairs) {}

void PairSweep::sort(const Box& box, const Particles& particles, const SweepSettings& settings,
                     [[maybe_unused]] int threads) {
    rows_.sort(box, particles, threads);
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    velocity_.resize(beads);
    word_.resize(beads);
    const auto key = bead_word_key(settings.seed, settings.step, settings.stream);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        velocity_[k] = {particles.velocity(id, 0), particles.velocity(id, 1), particles.velocity(id, 2),
                        particles.inverse_mass(id)};
        word_[k] = bead_word(order[k], key.data());
    }
    if (settings.shear_rate != 0.0) {
        for (std::size_t k = 0; k < beads; ++k) {
            velocity_[k].x -= settings.shear_rate * rows_.y()[k];
        }
    }
}

void PairSweep::gather_heat(const Particles& particles, const HeatPairs& pairs, [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    heat_.resize(beads);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const std::uint32_t id = order[k];
        const bool held = pairs.held[id] != 0;
        const double capacity = particles.heat_capacity[id];
        heat_[k] = {particles.temperature[id], capacity, held ? 0.0 : 1.0 / capacity, 0.0, held};
    }
}

void PairSweep::spread_heat(Particles& particles) {
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    heat_of_held_ = 0.0;
    for (std::size_t k = 0; k < beads; ++k) {
        const Heat& bead = heat_[k];
        if (bead.held) {
            heat_of_held_ += bead.gained;
        } else {
            particles.temperature[order[k]] = bead.temperature + bead.gained / bead.capacity;
        }
    }
}

template <bool heated>
PairSituation PairSweep::situation(const Row& row, std::size_t k, const SweepSettings& settings) const {
    const PairDrag& drag = table_.drags()[row.term[k]];
    const double closeness = 1.0 - std::sqrt(row.squared[k]) / drag.cutoff;
    PairSituation pair;
    pair.inverse_mass = velocity_[row.i[k]].inverse_mass + velocity_[row.j[k]].inverse_mass;
    pair.drag = settings.rate > 0.0 ? 2.0 * settings.rate / pair.inverse_mass : drag.drag;
    pair.weight =
        settings.weight_exponent == 2.0 ? closeness * closeness : std::pow(closeness, settings.weight_exponent);
    pair.duration = settings.duration;
    pair.thermal_energy = settings.thermal_energy;
    if constexpr (heated) {
        const HeatPairs& heat = *settings.heat;
        const std::uint32_t term = row.term[k];
        const Heat& one = heat_[row.i[k]];
        const Heat& other = heat_[row.j[k]];
        const double a = one.temperature;
        const double b = other.temperature;
        const double mean = 0.5 * (a + b);
        const double log_slope = heat.weight_varies(term) ? heat.log_slope(term, mean, std::log(closeness))
                                 : heat.drag_varies(term) ? heat.log_slope(term, mean, 0.0)
                                                          : 0.0;
        const double more =
            1.0 + HeatPairs::drag_of_noise(a, b, one.inverse_capacity, other.inverse_capacity, log_slope);
        pair.drag *= more;
        pair.thermal_energy = HeatPairs::thermal_energy(a, b) / more;
        if (heat.drag_varies(term)) {
            pair.drag *= heat.drag_factor(term, mean);
        }
        if (heat.weight_varies(term)) {
            pair.weight = std::pow(closeness, heat.weight_exponent(term, mean));
        }
    }
    return pair;
}

PairDraw PairSweep::draw_of(const Row& row, std::size_t k, const SweepSettings& settings, bool uniform_wanted,
                            double* across) const {
    const NormalTable& normal = normal_table();
    const std::uint32_t i = row.i[k];
    const std::uint32_t j = row.j[k];
    PairDraw result;
    if (settings.strong_noise) {
        const std::vector<std::uint32_t>& order = rows_.order();
        const std::uint32_t low = std::min(order[i], order[j]);
        const std::uint32_t high = std::max(order[i], order[j]);
        const Words words = draw(settings.seed, settings.stream, settings.step, low, high, row.image[k]);
        const auto two = gaussian_pair(words);
        result.normal = two[0];
        if (uniform_wanted || across != nullptr) {
            const Words more = draw(settings.seed, Stream::sweep_choice, settings.step, low, high, row.image[k]);
            if (across != nullptr) {
                const auto others = gaussian_pair(more);
                across[0] = two[1];
                across[1] = others[0];
                across[2] = others[1];
            }
            result.uniform = uniform(more[0], more[1]);
        }
        return result;
    }
    result.normal = normal(mix_words(word_[i], word_[j], row.image[k]));
    if (uniform_wanted) {
        const auto word = static_cast<std::uint32_t>(mix_words(word_[i], word_[j], uniform_salt + row.image[k]));
        result.uniform = (static_cast<double>(word) + 0.5) * 0x1p-32;
    }
    if (across != nullptr) {
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            across[axis] = normal(mix_words(word_[i], word_[j], (axis + 1) * across_salt + row.image[k]));
        }
    }
    return result;
}

template <bool heated, class Map>
void PairSweep::make_maps(const Row& row, Maps& maps, const Map& map, const SweepSettings& settings) const {
    const std::size_t pairs = row.size();
    maps.map.resize(pairs);
    maps.across.resize(settings.transverse_drag > 0.0 ? 3 * pairs : 0);
    for (std::size_t k = 0; k < pairs; ++k) {
        double* across = maps.across.empty() ? nullptr : &maps.across[3 * k];
        const PairDraw draw = draw_of(row, k, settings, Map::uniform, across);
        maps.map[k] = map(situation<heated>(row, k, settings), draw);
    }
}

template <bool sheared, bool heated>
void PairSweep::use_pair(const Row& row, const Maps& maps, std::size_t k, const SweepSettings& settings,
                         std::array<double, 6>* virial) {
    Velocity& a = velocity_[row.i[k]];
    Velocity& b = velocity_[row.j[k]];
    const double inverse = 1.0 / std::sqrt(row.squared[k]);
    const double ex = row.dx[k] * inverse, ey = row.dy[k] * inverse, ez = row.dz[k] * inverse;
    double relative_x = a.x - b.x;
    if constexpr (sheared) {
        relative_x += settings.shear_rate * row.dy[k];  // the flow at a bead and at the image it meets
    }
    const double u = ex * relative_x + ey * (a.y - b.y) + ez * (a.z - b.z);
    const double inverse_mass = a.inverse_mass + b.inverse_mass;
    const double along = ((maps.map[k].keep - 1.0) * u + maps.map[k].add) / inverse_mass;
    double px = along * ex, py = along * ey, pz = along * ez;
    if (settings.transverse_drag > 0.0) {
        // The exact solution of drag and noise across the axis; three numbers, of which the part along it is taken out.
        PairSituation pair = situation<heated>(row, k, settings);
        pair.drag *= settings.transverse_drag;
        const double x = pair.relaxation();
        const double lost = std::expm1(-x);
        const double noise = std::sqrt(-std::expm1(-2.0 * x) * pair.thermal_energy * inverse_mass);
        const double* n = &maps.across[3 * k];
        const double n_along = ex * n[0] + ey * n[1] + ez * n[2];
        px += (lost * (relative_x - u * ex) + noise * (n[0] - n_along * ex)) / inverse_mass;
        py += (lost * ((a.y - b.y) - u * ey) + noise * (n[1] - n_along * ey)) / inverse_mass;
        pz += (lost * ((a.z - b.z) - u * ez) + noise * (n[2] - n_along * ez)) / inverse_mass;
    }
    if constexpr (heated) {
        // What the pair's kinetic energy loses becomes heat of its beads, half for each.
        const double gained = -(px * relative_x + py * (a.y - b.y) + pz * (a.z - b.z) +
                                0.5 * (px * px + py * py + pz * pz) * inverse_mass);
        Heat& heat_a = heat_[row.i[k]];
        Heat& heat_b = heat_[row.j[k]];
        if (heat_a.lacks(0.5 * gained) || heat_b.lacks(0.5 * gained)) {
            return;  // a bead has less heat than the noise would take
        }
        heat_a.gained += 0.5 * gained;
        heat_b.gained += 0.5 * gained;
    }
    a.x += a.inverse_mass * px;
    a.y += a.inverse_mass * py;
    a.z += a.inverse_mass * pz;
    b.x -= b.inverse_mass * px;
    b.y -= b.inverse_mass * py;
    b.z -= b.inverse_mass * pz;
    if (virial != nullptr) {
        const std::array<double, 6> product{px * row.dx[k], px * row.dy[k], px * row.dz[k],
                                            py * row.dy[k], py * row.dz[k], pz * row.dz[k]};
        for (std::size_t n = 0; n < 6; ++n) {
            (*virial)[n] += product[n];
        }
    }
}

template <bool heated>
void PairSweep::use_maps(const Row& row, const Maps& maps, const SweepSettings& settings,
                         std::array<double, 6>* virial) {
    if (settings.shear_rate != 0.0) {
        use_all<true, heated>(row, maps, settings, virial);
    } else {
        use_all<false, heated>(row, maps, settings, virial);
    }
}

template <bool sheared, bool heated>
void PairSweep::use_all(const Row& row, const Maps& maps, const SweepSettings& settings,
                        std::array<double, 6>* virial) {
    const std::size_t pairs = row.size();
    if (settings.backward) {
        for (std::size_t k = pairs; k-- > 0;) {
            use_pair<sheared, heated>(row, maps, k, settings, virial);
        }
    } else {
        for (std::size_t k = 0; k < pairs; ++k) {
            use_pair<sheared, heated>(row, maps, k, settings, virial);
        }
    }
}

template <class Map>
void PairSweep::apply(const Box& box, Particles& particles, const Map& map, const SweepSettings& settings) {
    virial_.setZero();
    if (!rows_.any() || particles.count() == 0) {
        return;
    }
    const int threads = PairRows::useful_threads(particles);
    sort(box, particles, settings, threads);
    std::vector<std::array<double, 6>> virials(settings.observe ? rows_.count() : 0);
    maps_.resize(static_cast<std::size_t>(threads));
    if (settings.heat != nullptr) {
        gather_heat(particles, *settings.heat, threads);
        rows_.visit(settings.backward, threads, [&](const Row& row, std::size_t place, std::size_t thread) {
            make_maps<true>(row, maps_[thread], map, settings);
            use_maps<true>(row, maps_[thread], settings, settings.observe ? &virials[place] : nullptr);
        });
    } else {
        rows_.visit(settings.backward, threads, [&](const Row& row, std::size_t place, std::size_t thread) {
            make_maps<false>(row, maps_[thread], map, settings);
            use_maps<false>(row, maps_[thread], settings, settings.observe ? &virials[place] : nullptr);
        });
    }
    const std::vector<std::uint32_t>& order = rows_.order();
    const std::size_t beads = order.size();
    for (std::size_t k = 0; k < beads; ++k) {
        const Velocity& v = velocity_[k];
        if (!std::isfinite(v.x + v.y + v.z)) {
            throw RunFailure("step " + std::to_string(settings.step) + ": drag and noise made the velocity of bead " +
                             std::to_string(order[k] + 1) +
                             " something that is not a number; the timestep is too long for the drag");
        }
    }
    if (settings.heat != nullptr) {
        spread_heat(particles);
    }
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < beads; ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        particles.velocity(id, 0) = velocity_[k].x + settings.shear_rate * rows_.y()[k];
        particles.velocity(id, 1) = velocity_[k].y;
        particles.velocity(id, 2) = velocity_[k].z;
    }
    std::array<double, 6> sum{};
    for (const std::array<double, 6>& one : virials) {
        for (std::size_t n = 0; n < 6; ++n) {
            sum[n] += one[n] / settings.duration;
        }
    }
    virial_ << sum[0], sum[1], sum[2], sum[1], sum[3], sum[4], sum[2], sum[4], sum[5];
}

template void PairSweep::apply(const Box&, Particles&, const sweep::OrnsteinUhlenbeck&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::Shardlow&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::ImplicitEuler&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::PetersFirst&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::LoweAndersen&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::StoyanovGroot&, const SweepSettings&);
template void PairSweep::apply(const Box&, Particles&, const sweep::CommonDrag&, const SweepSettings&);

PairSweep::PairTemperature PairSweep::measure(const Box& box, const Particles& particles,
                                              const SweepSettings& settings) {
    PairTemperature total;
    if (!rows_.any() || particles.count() == 0) {
        return total;
    }
    const int threads = PairRows::useful_threads(particles);
    sort(box, particles, settings, threads);
    std::vector<PairTemperature> parts(rows_.count());  // added up in one order, whatever thread made them
    rows_.visit(settings.backward, threads, [&](const Row& row, std::size_t place, std::size_t) {
        PairTemperature& part = parts[place];
        for (std::size_t k = 0; k < row.size(); ++k) {
            const PairSituation pair = situation<false>(row, k, settings);
            const Velocity& a = velocity_[row.i[k]];
            const Velocity& b = velocity_[row.j[k]];
            const double relative_x = a.x - b.x + settings.shear_rate * row.dy[k];
            const double projection = row.dx[k] * relative_x + row.dy[k] * (a.y - b.y) + row.dz[k] * (a.z - b.z);
            const double u_squared = projection * projection / row.squared[k];
            const double w = std::sqrt(pair.weight);
            part.excess += pair.weight * (u_squared - settings.thermal_energy * pair.inverse_mass);
            part.energy += w * u_squared / pair.inverse_mass;
            part.weight += w;
            ++part.pairs;
        }
    });
    for (const PairTemperature& part : parts) {
        total.excess += part.excess;
        total.energy += part.energy;
        total.weight += part.weight;
        total.pairs += part.pairs;
    }
    return total;
}

}  // namespace dlpoly
