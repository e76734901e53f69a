// The pair loop (see pair_forces.hpp).
#include "forces/pair_forces.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "core/failure.hpp"
#include "core/random.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

// Below this many beads a thread, waiting for each other costs threads more than they bring.
constexpr std::int64_t beads_per_thread = 500;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

int useful_threads(std::int64_t beads) {
    return static_cast<int>(std::clamp<std::int64_t>(beads / beads_per_thread, 1, thread_limit()));
}

}  // namespace

PairForces::PairForces(PairTable table, double thermal_energy, double timestep)
    : table_(std::move(table)), phases_(&chosen_phases()), weights_(&weight_loops()), list_(*phases_) {
    double force = table_.characteristic_force(thermal_energy);
    for (const PairDrag& drag : table_.drags()) {
        force = std::max(force, 7.0 * drag.noise / std::sqrt(timestep));
    }
    any_law_or_noise_ = force > 0.0;
    force = std::max(force, 1e-12);
    base_exponent_ = grid_exponent(force);
    base_energy_exponent_ = grid_exponent(force * std::max(table_.range(), 1e-6));
}

void PairForces::add_modifier(std::shared_ptr<PairModifier> modifier) {
    // An estimate that beads never meet would cost digits: the grid becomes at most 64 times coarser than that of laws
    // and noise. Where it is too fine after all, compute() repeats its sums.
    constexpr int most = 6;
    const double force = modifier->characteristic_force();
    if (force > 0.0) {
        const int coarser = base_exponent_ - grid_exponent(force);
        const int bits = std::max(0, any_law_or_noise_ ? std::min(coarser, most) : coarser);
        base_exponent_ -= bits;
        base_energy_exponent_ -= bits;
    }
    modifiers_.push_back(std::move(modifier));
}

double PairForces::prepare_modifiers(const Box& box, const Particles& particles, int threads, bool conservative) {
    if (modifiers_.empty()) {
        return 0.0;
    }
    const double begin = now();
    for (const auto& modifier : modifiers_) {
        if (conservative || modifier->changes_motion()) {
            modifier->prepare(*this, box, particles, threads);
        }
    }
    return now() - begin;
}

void PairForces::compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                         PairTotals& totals) {
    totals = PairTotals();
    if (table_.range() <= 0.0 || particles.count() == 0) {
        particles.force.setZero();
        return;
    }
    PairWalk walk;
    walk.request = request;
    walk.motion = (request.drag || request.noise) && table_.has_drag();
    walk.threads = useful_threads(particles.count());
    update_list(box, particles, walk.threads);
    const double preparing = prepare_modifiers(box, particles, walk.threads, request.conservative);
    if (walk.motion) {
        gather_motion(velocity, request, walk.threads);
    }
    const double begin = now();
    int exponent = base_exponent_;
    int energy_exponent = base_energy_exponent_;
    // Forces beyond the grid's reach are rare (a random start): the sums are then repeated on a grid coarse enough. The
    // choice depends on the largest force alone, so it is the same for any number of threads and any cell layout.
    for (bool fits = false; !fits;) {
        walk.scale = std::ldexp(1.0, exponent);
        walk.energy_scale = std::ldexp(1.0, energy_exponent);
        if (walk.motion && watcher_ != nullptr) {
            walk.motion_visitor = watcher_;
            watcher_->begin(list_.order(), velocity, request, walk.threads);
        }
        const Largest largest = visit_pairs(walk);
        fits = largest.force < 1.0 && largest.energy < 1.0;
        exponent -= largest.force >= 1.0 ? std::ilogb(largest.force) + 1 : 0;
        energy_exponent -= largest.energy >= 1.0 ? std::ilogb(largest.energy) + 1 : 0;
    }
    ListWork work{preparing + now() - begin, list_.size(), 0};
    for (const auto& worker : workers_) {
        work.accepted += worker->accepted;
    }
    if (!request.observe || request.always_observed) {
        tuner_.walked(work);
    }
    spread_forces(particles, std::ldexp(1.0, -exponent), walk.threads);
    if (request.observe) {
        collect_totals(energy_exponent, totals);
        for (const auto& modifier : modifiers_) {
            totals.energy += request.conservative ? modifier->energy() : 0.0;
        }
    }
}

double PairForces::curvature(const Box& box, const Particles& particles) {
    if (table_.range() <= 0.0 || particles.count() == 0) {
        return 0.0;
    }
    PairWalk walk;
    walk.forces = false;
    walk.frozen = particles.frozen.data();
    walk.threads = useful_threads(particles.count());
    const double range = table_.range();
    const int exponent = base_exponent_ + std::min(0, static_cast<int>(std::floor(std::log2(range))));
    walk.scale = std::ldexp(1.0, exponent);
    update_list(box, particles, walk.threads);
    static_cast<void>(prepare_modifiers(box, particles, walk.threads, true));
    static_cast<void>(visit_pairs(walk));
    WideSum sum;
    bool lost = false;
    for (const auto& worker : workers_) {
        sum.add(worker->curvature);
        lost = lost || worker->curvature_lost;
    }
    double of_beads = 0.0;
    for (const auto& modifier : modifiers_) {
        of_beads += modifier->curvature(*this, box, particles);
    }
    return lost ? std::numeric_limits<double>::quiet_NaN() : sum.value(exponent) + of_beads;
}

void PairForces::visit(const Box& box, const Particles& particles, PairVisitor& visitor) {
    if (table_.range() <= 0.0 || particles.count() == 0) {
        return;
    }
    const int threads = useful_threads(particles.count());
    update_list(box, particles, threads);
    if (visitor.wants_factors()) {
        static_cast<void>(prepare_modifiers(box, particles, threads, true));
    }
    show(visitor, threads);
}

void PairForces::visit_motion(const Box& box, const Particles& particles, const Array3N& velocity,
                              const ForceRequest& request, MotionVisitor& visitor) {
    if (!table_.has_drag() || particles.count() == 0) {
        return;
    }
    PairWalk walk;
    walk.request = request;
    walk.forces = false;
    walk.motion_visitor = &visitor;
    walk.threads = useful_threads(particles.count());
    update_list(box, particles, walk.threads);
    prepare_modifiers(box, particles, walk.threads, false);
    gather_motion(velocity, request, walk.threads);
    visitor.begin(list_.order(), velocity, request, walk.threads);
    static_cast<void>(visit_pairs(walk));
}

void PairForces::show(PairVisitor& visitor, int threads) {
    PairWalk walk;
    walk.forces = false;
    walk.visitor = &visitor;
    walk.threads = threads;
    static_cast<void>(visit_pairs(walk));
}

void PairForces::add_curvature(const PairWalk& walk, PairWorker& worker) const {
    constexpr double largest = 0x1p61;  // WideSum takes terms of 64 bits
    const PairKernel* kernel = table_.kernel(worker.batch.term);
    if (kernel == nullptr) {
        return;
    }
    const std::vector<std::uint32_t>& order = list_.order();
    std::array<double, batch_capacity> curvature;
    pair_curvature(*kernel, worker.batch, curvature.data());
    for (const auto& modifier : modifiers_) {
        modifier->change_curvature(worker.batch, curvature.data());
    }
    for (std::size_t k = 0; k < worker.batch.size; ++k) {
        const std::uint32_t i = worker.batch.i.values[k];
        const std::uint32_t j = worker.batch.j.values[k];
        if (i == j) {
            continue;  // a bead and its own image move together
        }
        const int mobile = (walk.frozen[order[i]] == 0 ? 1 : 0) + (walk.frozen[order[j]] == 0 ? 1 : 0);
        const double value = mobile * walk.scale * curvature[k];
        if (std::abs(value) < largest) {
            worker.curvature.add(std::llrint(value));
        } else {
            worker.curvature_lost = true;
        }
    }
}

void PairForces::update_list(const Box& box, const Particles& particles, int threads) {
    if (list_.refresh(box, particles, threads)) {
        return;
    }
    tuner_.given_up(list_.displacement(), list_.evaluations());
    const double skin = tuner_.skin(table_.range());
    const double begin = now();
    list_.build(box, particles, table_, exclusions_, skin, cell_width_, threads);
    tuner_.built(table_.range(), skin, now() - begin);
}

void PairForces::gather_motion(const Array3N& velocity, const ForceRequest& request, [[maybe_unused]] int threads) {
    const std::vector<std::uint32_t>& order = list_.order();
    motion_.resize(order.size());
    const auto word_key = bead_word_key(request.seed, request.step);
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < order.size(); ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        motion_[k] = {velocity(id, 0), velocity(id, 1), velocity(id, 2), bead_word(order[k], word_key.data())};
    }
    if (request.shear_rate != 0.0) {
        for (std::size_t k = 0; k < order.size(); ++k) {
            motion_[k].x -= request.shear_rate * list_.beads()[k].y;
        }
    }
}

void PairForces::spread_forces(Particles& particles, double unit, [[maybe_unused]] int threads) const {
    const std::vector<std::uint32_t>& order = list_.order();
    double* force = particles.force.data();
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t k = 0; k < order.size(); ++k) {
        const GridForce& sum = sums_[k];
        double* bead = force + 3 * std::size_t{order[k]};
        const bool mobile = particles.frozen[order[k]] == 0;
        bead[0] = mobile ? static_cast<double>(sum.x) * unit : 0.0;
        bead[1] = mobile ? static_cast<double>(sum.y) * unit : 0.0;
        bead[2] = mobile ? static_cast<double>(sum.z) * unit : 0.0;
    }
}

void PairForces::collect_totals(int energy_exponent, PairTotals& totals) const {
    WideSum energy;
    std::array<std::array<WideSum, 6>, 3> virial{};
    for (const auto& worker : workers_) {
        energy.add(worker->energy);
        for (std::size_t part = 0; part < 3; ++part) {
            for (std::size_t k = 0; k < 6; ++k) {
                virial[part][k].add(worker->virial[part][k]);
            }
        }
    }
    totals.energy = energy.value(energy_exponent);
    const std::array<Matrix3*, 3> tensors{&totals.conservative, &totals.drag, &totals.noise};
    for (std::size_t part = 0; part < 3; ++part) {
        std::size_t k = 0;
        for (Eigen::Index a = 0; a < 3; ++a) {
            for (Eigen::Index b = a; b < 3; ++b) {
                const double value = virial[part][k++].value(energy_exponent);
                (*tensors[part])(a, b) = value;
                (*tensors[part])(b, a) = value;
            }
        }
    }
}

// One walk over all pairs. Returns the largest terms met, in units of the largest the grids allow.
PairForces::Largest PairForces::visit_pairs(const PairWalk& walk) {
    sums_.resize(list_.beads().size());
    workers_.resize(static_cast<std::size_t>(walk.threads));
    for (auto& worker : workers_) {
        if (!worker) {
            worker = std::make_unique<PairWorker>();
        }
        worker->reset();
    }
#ifdef _OPENMP
#pragma omp parallel num_threads(walk.threads)
#endif
    {
        PairWorker& worker = *workers_[static_cast<std::size_t>(thread_number())];
#ifdef _OPENMP
#pragma omp for schedule(static)
#endif
        for (std::size_t k = 0; k < (walk.forces ? sums_.size() : 0); ++k) {
            sums_[k] = GridForce{0, 0, 0, 0};
        }
        for (const std::vector<std::int32_t>& group : list_.cells().row_groups()) {
            const auto rows = static_cast<std::int64_t>(group.size());
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 1)
#endif
            for (std::int64_t k = 0; k < rows; ++k) {
                visit_row(list_.row(group[static_cast<std::size_t>(k)]), walk, worker);
            }
        }
        finish_batch(walk, worker);
    }
    Largest largest;
    const PairWorker* worst = workers_.front().get();
    for (const auto& worker : workers_) {
        worst = worker->largest > worst->largest ? worker.get() : worst;
        largest.force = std::max(largest.force, worker->largest);
        largest.energy = std::max(largest.energy, worker->largest_energy);
    }
    if (std::isinf(largest.force)) {
        report_overflow(*worst, walk.request.step);
    }
    return largest;
}

void PairForces::visit_row(const ListRow& row, const PairWalk& walk, PairWorker& worker) {
    FilterArguments filter{};
    filter.beads = list_.beads().data();
    filter.shifts = list_.shifts().data();
    filter.zero = list_.zero_shift();
    filter.images = !list_.image_codes().empty();
    filter.entries = row.entries.data();
    filter.segments = row.segments.data();
    for (const ListRow::Block& block : row.blocks) {
        if (block.term != worker.batch.term) {
            finish_batch(walk, worker);
            worker.batch.term = block.term;
        }
        worker.batch.reach_squared = table_.reach_squared()[block.term];
        if (walk.visitor != nullptr) {
            worker.batch.reach_squared = walk.visitor->reach_squared(block.term, worker.batch.reach_squared);
        }
        filter.segment = block.first;
        filter.last_segment = block.last;
        filter.entry = row.segments[block.first].first;
        while (!phases_->filter(filter, worker.batch)) {
            finish_batch(walk, worker);
        }
    }
    // The row's pairs must be added before another thread may touch the rows it shares.
    if (walk.threads > 1) {
        finish_batch(walk, worker);
    }
}

void PairForces::finish_batch(const PairWalk& walk, PairWorker& worker) {
    PairBatch& batch = worker.batch;
    if (batch.size == 0) {
        return;
    }
    if (!walk.forces) {
        if (walk.motion_visitor != nullptr) {
            if (table_.drags()[batch.term].drag > 0.0) {
                find_motion(batch, worker.result, walk.request);
                walk.motion_visitor->visit(batch, worker.result, thread_number());
            }
        } else if (walk.visitor == nullptr) {
            add_curvature(walk, worker);
        } else if (!walk.visitor->wants_factors()) {
            walk.visitor->visit(batch, nullptr, list_.order().data(), thread_number());
        } else if (const PairKernel* kernel = table_.kernel(batch.term)) {
            kernel->evaluate(batch, worker.result);
            for (const auto& modifier : modifiers_) {
                modifier->change_conservative(batch, worker.result);
            }
            walk.visitor->visit(batch, worker.result.conservative.values, list_.order().data(), thread_number());
        }
        batch.size = 0;
        batch.runs = 0;
        return;
    }
    BatchResult& result = worker.result;
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    if (const PairKernel* kernel = walk.request.conservative ? table_.kernel(batch.term) : nullptr) {
        kernel->evaluate(batch, result);
        for (const auto& modifier : modifiers_) {
            modifier->change_conservative(batch, result);
        }
    } else {
        std::fill_n(result.energy.values, whole, 0.0);
        std::fill_n(result.conservative.values, whole, 0.0);
    }
    const bool motion = walk.motion && table_.drags()[batch.term].drag > 0.0;
    if (motion) {
        find_motion(batch, result, walk.request);
        if (walk.motion_visitor != nullptr) {
            walk.motion_visitor->visit(batch, result, thread_number());
        }
    }
    bool fits = phases_->round(batch, result, motion, walk.scale);
    if (fits) {
        phases_->add(batch, result, sums_.data());
    }
    if (walk.request.observe) {
        ObservedSums sums;
        fits = phases_->observe(batch, result, motion, walk.energy_scale, sums) && fits;
        if (fits) {
            worker.energy.add(sums.energy);
            for (std::size_t part = 0; part < 3; ++part) {
                for (std::size_t k = 0; k < 6; ++k) {
                    worker.virial[part][k].add(sums.virial[part][k]);
                }
            }
        }
    }
    if (!fits) {
        find_worst(walk, worker);  // this walk is repeated on a coarser grid
    }
    worker.accepted += static_cast<std::int64_t>(batch.size);
    batch.size = 0;
    batch.runs = 0;
}

// Drag and noise of a batch with all that changes them.
void PairForces::find_motion(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const {
    const auto changes_weight = [&batch](const auto& modifier) { return modifier->changes_weight(batch.term); };
    if (request.weight_exponent != 2.0 && std::any_of(modifiers_.begin(), modifiers_.end(), changes_weight)) {
        ForceRequest squared = request;
        squared.weight_exponent = 2.0;
        find_motion(batch, result, squared);
        return;
    }
    evaluate_motion(batch, result, request);
    if (request.shear_rate != 0.0 && request.drag) {
        add_drag_of_shear(batch, result, request);
    }
    for (const auto& modifier : modifiers_) {
        if (modifier->changes_motion()) {
            modifier->change_motion(batch, result, table_.drags()[batch.term], request);
        }
    }
}

// Looks for the largest terms of a batch in which at least one is beyond its grid.
void PairForces::find_worst(const PairWalk& walk, PairWorker& worker) const {
    const PairBatch& batch = worker.batch;
    const BatchResult& result = worker.result;
    const bool motion = walk.motion && table_.drags()[batch.term].drag > 0.0;
    for (std::size_t k = 0; k < batch.size; ++k) {
        const std::array<double, 3> parts{result.conservative.values[k], motion ? result.drag.values[k] : 0.0,
                                          motion ? result.noise.values[k] : 0.0};
        const double factor = motion ? parts[0] + parts[1] + parts[2] : parts[0];
        double largest = 0.0;
        for (const double d : {batch.dx.values[k], batch.dy.values[k], batch.dz.values[k]}) {
            largest = std::max(largest, std::abs(factor * d * walk.scale));
        }
        double largest_energy = 0.0;
        if (walk.request.observe) {
            const double reach = batch.distance_squared.values[k] * walk.energy_scale;
            largest_energy = std::abs(result.energy.values[k]) * walk.energy_scale;
            for (const double part : parts) {
                largest_energy = std::max(largest_energy, std::abs(part) * reach);
            }
        }
        if (!std::isfinite(factor) || !std::isfinite(largest_energy)) {
            largest = std::numeric_limits<double>::infinity();
        }
        worker.largest_energy = std::max(worker.largest_energy, largest_energy / largest_term);
        if (largest >= largest_term && largest / largest_term > worker.largest) {
            worker.largest = largest / largest_term;
            worker.largest_i = batch.i.values[k];
            worker.largest_j = batch.j.values[k];
            worker.largest_distance = std::sqrt(batch.distance_squared.values[k]);
        }
    }
}

void PairForces::report_overflow(const PairWorker& worst, std::uint64_t step) const {
    const std::vector<std::uint32_t>& order = list_.order();
    const std::uint32_t first = std::min(order[worst.largest_i], order[worst.largest_j]) + 1;
    const std::uint32_t second = std::max(order[worst.largest_i], order[worst.largest_j]) + 1;
    std::ostringstream text;
    text.precision(6);
    text << "step " << step << ": the pair force between beads " << first << " and " << second
         << " is not finite at a distance of " << worst.largest_distance
         << "; a law that diverges at contact needs beads that do not coincide";
    throw RunFailure(text.str());
}

}  // namespace dlpoly
