// The bonded terms (see bonded_forces.hpp).
#include "bonded/bonded_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/exact_sum.hpp"
#include "core/failure.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

// Terms a thread should have before another one pays for the waiting.
constexpr std::size_t terms_a_thread = 2000;
// How much finer than that of the forces the grid of energies is: by log2(largest_wide_term / largest_term).
constexpr int wide_bits = 10;

const bonded::LawInfo& scaled_pair_info() {
    static constexpr bonded::LawInfo info{.kind = bonded::Kind::dihedral,
                                          .key = "",
                                          .restraint_key = "",
                                          .description = "1-4 pair",
                                          .parameter_names = {},
                                          .energy_mask = 0,
                                          .limit = "the beads coincide"};
    return info;
}

}  // namespace

BondedForces::BondedForces(std::vector<std::uint8_t> frozen, double thermal_energy)
    : frozen_(std::move(frozen)), thermal_energy_(thermal_energy) {}

void BondedForces::add(bonded::Kind kind, std::string_view key, std::span<const double> parameters,
                       std::span<const std::uint32_t> beads) {
    const std::size_t width = bonded::beads_of_kind[bonded::index(kind)];
    if (beads.size() % width != 0) {
        throw std::invalid_argument("the beads of bonded terms do not come in groups of the right size");
    }
    if (kind == bonded::Kind::tether && anchors_.rows() == 0) {
        throw std::invalid_argument("tethers need their anchors first");
    }
    auto list = std::find_if(lists_.begin(), lists_.end(),
                             [&](const auto& l) { return l->info().kind == kind && l->info().key == key; });
    if (list == lists_.end()) {
        lists_.push_back(bonded::make_term_list(kind, key));
        list = lists_.end() - 1;
    }
    const bonded::Magnitude magnitude = (*list)->set_parameters(parameters, thermal_energy_);
    largest_.force = std::max(largest_.force, magnitude.force);
    largest_.energy = std::max(largest_.energy, magnitude.energy);
    for (std::size_t k = 0; k < beads.size(); k += width) {
        const auto term = beads.subspan(k, width);
        bool mobile = false;
        for (std::size_t a = 0; a < width; ++a) {
            if (term[a] >= frozen_.size() || std::find(term.begin(), term.begin() + static_cast<std::ptrdiff_t>(a),
                                                       term[a]) != term.begin() + static_cast<std::ptrdiff_t>(a)) {
                throw std::invalid_argument("a bonded term has a bead twice or one that does not exist");
            }
            mobile = mobile || frozen_[term[a]] == 0;
            bead_end_ = std::max(bead_end_, term[a] + 1);
        }
        if (mobile) {
            (*list)->add(term.data());
        }
    }
    bounds_.clear();
}

int BondedForces::energy_exponent() const noexcept {
    return wide_bits + grid_exponent(std::max(largest_.energy, 1e-12));
}

void BondedForces::set_anchors(Array3N anchors) {
    if (anchors.rows() != static_cast<Eigen::Index>(frozen_.size()) || !anchors.allFinite()) {
        throw std::invalid_argument("anchors must be finite and of shape (N, 3)");
    }
    anchors_ = std::move(anchors);
}

void BondedForces::add_scaled_pair(std::uint32_t i, std::uint32_t j, double scale) {
    if (i >= frozen_.size() || j >= frozen_.size() || i == j || !std::isfinite(scale)) {
        throw std::invalid_argument("a scaled pair needs two beads and a finite factor");
    }
    if (frozen_[i] == 0 || frozen_[j] == 0) {
        scaled_.push_back({i, j, scale});
    }
    bounds_.clear();
}

std::size_t BondedForces::part_of(std::uint32_t bead) const {
    return static_cast<std::size_t>(std::upper_bound(bounds_.begin(), bounds_.end(), bead) - bounds_.begin() - 1);
}

void BondedForces::prepare(std::size_t parts) {
    if (bounds_.size() == parts + 1) {
        return;
    }
    bounds_.resize(parts + 1);
    for (std::size_t p = 0; p <= parts; ++p) {
        bounds_[p] = static_cast<std::uint32_t>(frozen_.size() * p / parts);
    }
    for (const auto& list : lists_) {
        list->partition(bounds_);
    }
}

void BondedForces::part(std::size_t p, const bonded::MinimumImage& image, const double* positions,
                        std::span<const std::int32_t> species, const PairTable& pairs, bonded::Worker& worker) const {
    const bonded::Places places{image, positions, anchors_.data()};
    for (const auto& list : lists_) {
        list->evaluate(p, places, worker);
    }
    // Few: each part looks through all of them for its own.
    const std::size_t parts = bounds_.size() - 1;
    for (const ScaledPair& pair : scaled_) {
        const std::size_t of_i = part_of(pair.i);
        if (p == (of_i == part_of(pair.j) ? of_i : parts)) {
            scaled_pair(pair, places, species, pairs, worker);
        }
    }
}

// The pair's own law as the pair loop has it, shift and cutoff included, times the factor.
void BondedForces::scaled_pair(const ScaledPair& pair, const bonded::Places& places,
                               std::span<const std::int32_t> species, const PairTable& pairs,
                               bonded::Worker& worker) const {
    const std::uint32_t term = pairs.term(species[pair.i], species[pair.j]);
    const PairKernel* kernel = pairs.kernel(term);
    if (kernel == nullptr) {
        return;  // no law acts between these species
    }
    bonded::Failure failure{&scaled_pair_info(), false, 0.0, {pair.i, pair.j, 0, 0}};
    Vector3 d = places.position(pair.i) - places.position(pair.j);
    const bool certain = places.image.shorten(d);
    failure.length = d.norm();
    if (!certain) {
        if (pairs.reach_squared()[term] <= places.image.limit() * places.image.limit()) {
            return;  // out of reach in every image
        }
        failure.too_long = true;
        worker.fail(failure);
        return;
    }
    PairBatch batch;
    BatchResult result;
    batch.size = 1;
    batch.term = term;
    batch.reach_squared = std::numeric_limits<double>::infinity();  // the law checks its own cutoff
    std::fill_n(batch.distance_squared.values, batch_lanes, d.squaredNorm());
    kernel->evaluate(batch, result);
    const double factor = pair.scale * result.conservative.values[0];
    const std::array<std::uint32_t, 2> beads{pair.i, pair.j};
    if (!std::isfinite(factor) ||
        !worker.add<2>(bonded::scaled_pairs, beads, pair.scale * result.energy.values[0], {factor * d}, {d})) {
        worker.fail(failure);
    }
}

double BondedForces::curvature(const Box& box, const Particles& particles, const PairTable& pairs) const {
    const bonded::MinimumImage image(box);
    const bonded::Places places{image, particles.position.data(), anchors_.data()};
    const double force = std::max(largest_.force, 1e-12);
    const double force_scale = std::ldexp(1.0, grid_exponent(force));
    bonded::CurvatureSum total;
    total.scale = std::ldexp(1.0, grid_exponent(force));
    for (const auto& list : lists_) {
        const auto chunks = static_cast<std::int64_t>(1 + list->size() / terms_a_thread);
        std::vector<bonded::CurvatureSum> sums(static_cast<std::size_t>(chunks), total);
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1)
#endif
        for (std::int64_t c = 0; c < chunks; ++c) {
            const std::size_t first = list->size() * static_cast<std::size_t>(c) / static_cast<std::size_t>(chunks);
            const std::size_t last = list->size() * static_cast<std::size_t>(c + 1) / static_cast<std::size_t>(chunks);
            bonded::CurvatureSum& sum = sums[static_cast<std::size_t>(c)];
            sum.sum = WideSum();
            list->add_curvature(first, last, places, frozen_, force_scale, sum);
        }
        for (const bonded::CurvatureSum& sum : sums) {
            total.sum.add(sum.sum);
            total.lost = total.lost || sum.lost;
        }
    }
    for (const ScaledPair& pair : scaled_) {
        Vector3 d = places.position(pair.i) - places.position(pair.j);
        const std::uint32_t term = pairs.term(particles.species[pair.i], particles.species[pair.j]);
        if (!places.image.shorten(d) || pairs.kernel(term) == nullptr) {
            continue;
        }
        const int mobile = (frozen_[pair.i] == 0 ? 1 : 0) + (frozen_[pair.j] == 0 ? 1 : 0);
        PairBatch batch;
        batch.size = 1;
        batch.term = term;
        std::fill_n(batch.distance_squared.values, batch_lanes, d.squaredNorm());
        double curvature = 0.0;
        pair_curvature(*pairs.kernel(term), batch, &curvature);
        total.add(pair.scale * mobile * curvature);
    }
    return total.lost ? std::numeric_limits<double>::quiet_NaN() : total.sum.value(grid_exponent(force));
}

void BondedForces::visit(const Box& box, const Particles& particles, const PairTable& pairs, std::uint64_t step,
                         bonded::TermVisitor& visitor) {
    if (bounds_.empty()) {
        prepare(1);
    }
    const bonded::MinimumImage image(box);
    bonded::Request request;
    request.observe = true;
    request.visitor = &visitor;
    bonded::Worker worker(request, nullptr);  // no force is added
    for (std::size_t p = 0; p < bounds_.size(); ++p) {
        part(p, image, particles.position.data(), particles.species, pairs, worker);
    }
    report(std::span(&worker, 1), image, step);
}

void BondedForces::report(std::span<const bonded::Worker> workers, const bonded::MinimumImage& image,
                          std::uint64_t step) {
    bonded::Failure first;
    for (const bonded::Worker& worker : workers) {
        first = worker.failure().before(first) ? worker.failure() : first;
    }
    if (first.law == nullptr) {
        return;
    }
    std::ostringstream text;
    text.precision(6);
    const bool pair = first.law->key.empty();
    const std::size_t count = pair ? 2 : bonded::beads_of_kind[bonded::index(first.law->kind)];
    text << "step " << step << ": the "
         << (pair ? std::string("1-4 pair")
                  : std::string(bonded::name(first.law->kind)) + " " + std::string(first.law->key))
         << (count == 1 ? " of bead " : " of beads ");
    for (std::size_t k = 0; k < count; ++k) {
        text << (k == 0 ? "" : k + 1 == count ? " and " : ", ") << first.beads[k] + 1;
    }
    if (first.too_long) {
        text << " has beads " << first.length << " apart, more than half the cell's width (" << image.limit()
             << "): which image is meant is not certain";
    } else {
        text << " is not finite";
        if (count <= 2) {
            text << " at a length of " << first.length;
        }
        if (!first.law->limit.empty()) {
            text << ": " << first.law->limit;
        }
    }
    throw RunFailure(text.str());
}

BondedTotals BondedForces::total(std::span<const bonded::Worker> workers, int energy_exponent) {
    BondedTotals totals;
    for (std::size_t c = 0; c < bonded::components; ++c) {
        WideSum energy;
        for (const bonded::Worker& worker : workers) {
            energy.add(worker.energy(c));
        }
        totals.energy[c] = energy.value(energy_exponent);
        for (std::size_t k = 0; k < 9; ++k) {
            WideSum virial;
            for (const bonded::Worker& worker : workers) {
                virial.add(worker.virial(c, k));
            }
            totals.virial[c](static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3)) =
                virial.value(energy_exponent);
        }
    }
    return totals;
}

void BondedForces::add_to(const Box& box, Particles& particles, const PairTable& pairs, std::uint64_t step,
                          BondedTotals* totals) {
    const bonded::MinimumImage image(box);
    std::size_t terms = scaled_.size();
    for (const auto& list : lists_) {
        terms += list->size();
    }
    const std::size_t parts =
        std::clamp<std::size_t>(terms / terms_a_thread, 1, static_cast<std::size_t>(thread_limit()));
    prepare(parts);
    // The grid of a scaled pair is that of the pair forces it belongs to.
    if (!scaled_.empty() && pair_force_ < 0.0) {
        pair_force_ = pairs.characteristic_force(thermal_energy_);
    }
    int exponent = grid_exponent(std::max({largest_.force, pair_force_, 1e-12}));
    int energy_exponent = wide_bits + grid_exponent(std::max({largest_.energy, pair_force_ * pairs.range(), 1e-12}));
    for (;;) {
        sums_.assign(3 * frozen_.size(), 0);
        const bonded::Request request{Vector3::Constant(std::ldexp(1.0, exponent)), std::ldexp(1.0, energy_exponent),
                                      totals != nullptr};
        std::vector<bonded::Worker> workers(parts + 1, bonded::Worker(request, sums_.data()));
        const auto count = static_cast<std::int64_t>(parts);
#ifdef _OPENMP
#pragma omp parallel for schedule(static, 1) if (parts > 1)
#endif
        for (std::int64_t p = 0; p < count; ++p) {
            const auto k = static_cast<std::size_t>(p);
            part(k, image, particles.position.data(), particles.species, pairs, workers[k]);
        }
        part(parts, image, particles.position.data(), particles.species, pairs, workers[parts]);
        report(workers, image, step);
        double largest = 0.0;
        double largest_energy = 0.0;
        for (const bonded::Worker& worker : workers) {
            largest = std::max(largest, worker.largest());
            largest_energy = std::max(largest_energy, worker.largest_energy());
        }
        if (largest < 1.0 && largest_energy < 1.0) {
            if (totals != nullptr) {
                *totals = total(workers, energy_exponent);
            }
            break;
        }
        // Terms beyond the grid's reach are rare (a random start); the choice depends on the largest one alone.
        exponent -= largest >= 1.0 ? std::ilogb(largest) + 1 : 0;
        energy_exponent -= largest_energy >= 1.0 ? std::ilogb(largest_energy) + 1 : 0;
    }
    const double unit = std::ldexp(1.0, -exponent);
    for (std::size_t i = 0; i < frozen_.size(); ++i) {
        if (frozen_[i] == 0) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                particles.force(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) +=
                    static_cast<double>(sums_[3 * i + axis]) * unit;
            }
        }
    }
}

}  // namespace dlpoly
