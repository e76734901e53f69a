// The pair loop (see pair_forces.hpp).
#include "forces/pair_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "core/failure.hpp"
#include "core/random.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

// The image code of a shift, seen from the bead it belongs to: 0 for the cell itself.
std::uint8_t image_code(const std::array<std::int32_t, 3>& shift, int sign) {
    std::int32_t code = 0;
    for (const std::int32_t s : shift) {
        code = code * 6 + ((sign * s) % 6 + 6) % 6;
    }
    return static_cast<std::uint8_t>(code);
}

}  // namespace

PairForces::PairForces(PairTable table, double thermal_energy, double timestep) : table_(std::move(table)) {
    double force = table_.characteristic_force(thermal_energy);
    for (const PairDrag& drag : table_.drags()) {
        force = std::max(force, 7.0 * drag.noise / std::sqrt(timestep));
    }
    force = std::max(force, 1e-12);
    base_exponent_ = grid_exponent(force);
    base_energy_exponent_ = grid_exponent(force * std::max(table_.range(), 1e-6));
}

void PairForces::gather(const Particles& particles, const Array3N& velocity, const ForceRequest& request) {
    const std::vector<std::uint32_t>& order = cells_.order();
    const std::size_t beads = order.size();
    for (auto* array : {&x_, &y_, &z_}) {
        array->resize(beads);
    }
    species_.resize(beads);
    frozen_.resize(beads);
    if (request.drag) {
        for (auto* array : {&vx_, &vy_, &vz_}) {
            array->resize(beads);
        }
        words_.resize(beads);
    }
    const auto word_key = bead_word_key(request.seed, request.step);
    any_frozen_ = false;
    for (std::size_t k = 0; k < beads; ++k) {
        const auto id = static_cast<Eigen::Index>(order[k]);
        x_[k] = particles.position(id, 0);
        y_[k] = particles.position(id, 1);
        z_[k] = particles.position(id, 2);
        species_[k] = particles.species[order[k]];
        frozen_[k] = particles.frozen[order[k]];
        any_frozen_ = any_frozen_ || frozen_[k] != 0;
        if (request.drag) {
            words_[k] = bead_word(order[k], word_key.data());
            vx_[k] = velocity(id, 0);
            vy_[k] = velocity(id, 1);
            vz_[k] = velocity(id, 2);
        }
    }
}

void PairForces::compute(const Box& box, Particles& particles, const Array3N& velocity, const ForceRequest& request,
                         PairTotals& totals) {
    particles.force.setZero();
    totals = PairTotals();
    if (table_.range() <= 0.0 || particles.count() == 0) {
        return;
    }
    cells_.build(box, particles.position, table_.range(), cell_width_);
    gather(particles, velocity, request);
    int exponent = base_exponent_;
    int energy_exponent = base_energy_exponent_;
    // Forces beyond the grid's reach are rare (a random start): the sums are then repeated on a grid coarse enough. The
    // choice depends on the largest force alone, so it is the same for any number of threads and any cell layout.
    for (Largest largest = visit_pairs(box, request, exponent, energy_exponent);
         largest.force >= 1.0 || largest.energy >= 1.0;
         largest = visit_pairs(box, request, exponent, energy_exponent)) {
        exponent -= largest.force >= 1.0 ? std::ilogb(largest.force) + 1 : 0;
        energy_exponent -= largest.energy >= 1.0 ? std::ilogb(largest.energy) + 1 : 0;
    }
    const std::vector<std::uint32_t>& order = cells_.order();
    const double unit = std::ldexp(1.0, -exponent);
    for (std::size_t k = 0; k < order.size(); ++k) {
        if (frozen_[k] == 0) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                particles.force(static_cast<Eigen::Index>(order[k]), static_cast<Eigen::Index>(axis)) =
                    static_cast<double>(sums_[3 * k + axis]) * unit;
            }
        }
    }
    if (request.observe) {
        WideSum energy;
        std::array<WideSum, 9> conservative{}, drag{}, noise{};
        for (const PairWorker& worker : workers_) {
            energy.add(worker.energy);
            for (std::size_t k = 0; k < 9; ++k) {
                conservative[k].add(worker.conservative[k]);
                drag[k].add(worker.drag[k]);
                noise[k].add(worker.noise[k]);
            }
        }
        totals.energy = energy.value(energy_exponent);
        for (Eigen::Index k = 0; k < 9; ++k) {
            totals.conservative(k / 3, k % 3) = conservative[static_cast<std::size_t>(k)].value(energy_exponent);
            totals.drag(k / 3, k % 3) = drag[static_cast<std::size_t>(k)].value(energy_exponent);
            totals.noise(k / 3, k % 3) = noise[static_cast<std::size_t>(k)].value(energy_exponent);
        }
    }
}

// One walk over all pairs. Returns the largest terms met, in units of the largest the grids allow.
PairForces::Largest PairForces::visit_pairs(const Box& box, const ForceRequest& request, int exponent,
                                            int energy_exponent) {
    sums_.assign(3 * cells_.order().size(), 0);
    workers_.resize(static_cast<std::size_t>(thread_limit()));
    for (PairWorker& worker : workers_) {
        worker.reset(table_.batch_kinds(), request, exponent, energy_exponent);
    }
#ifdef _OPENMP
#pragma omp parallel
#endif
    {
        PairWorker& worker = workers_[static_cast<std::size_t>(thread_number())];
        for (const std::vector<std::int32_t>& group : cells_.row_groups()) {
            const auto rows = static_cast<std::int64_t>(group.size());
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 1)
#endif
            for (std::int64_t k = 0; k < rows; ++k) {
                search_row(box, group[static_cast<std::size_t>(k)], worker);
            }
        }
    }
    Largest largest;
    const PairWorker* worst = &workers_.front();
    for (const PairWorker& worker : workers_) {
        worst = worker.largest > worst->largest ? &worker : worst;
        largest.force = std::max(largest.force, worker.largest);
        largest.energy = std::max(largest.energy, worker.largest_energy);
    }
    if (std::isinf(largest.force)) {
        report_overflow(*worst);
    }
    return largest;
}

void PairForces::search_row(const Box& box, std::int32_t row, PairWorker& worker) {
    const std::int32_t length = cells_.row_length();
    for (std::int32_t cell = row * length; cell < (row + 1) * length; ++cell) {
        const std::uint32_t begin = cells_.start(cell);
        const std::uint32_t end = cells_.start(cell + 1);
        if (begin == end) {
            continue;
        }
        search_cell_pair(begin, end, begin, end, true, Vector3::Zero(), 0, 0, worker);
        cells_.neighbours(cell, worker.neighbours);
        for (const CellImage& other : worker.neighbours) {
            const std::uint32_t other_begin = cells_.start(other.cell);
            const std::uint32_t other_end = cells_.start(other.cell + 1);
            if (other_begin == other_end) {
                continue;
            }
            const Vector3 shift = (box.cell().row(0) * other.shift[0] + box.cell().row(1) * other.shift[1] +
                                   box.cell().row(2) * other.shift[2])
                                      .transpose();
            const bool several = cells_.has_several_images();
            search_cell_pair(begin, end, other_begin, other_end, false, shift,
                             several ? image_code(other.shift, 1) : std::uint8_t{0},
                             several ? image_code(other.shift, -1) : std::uint8_t{0}, worker);
        }
    }
    // The row's batches must be added before another thread may touch the rows it shares.
    for (std::size_t kind = 0; kind < worker.batches.size(); ++kind) {
        flush(kind, worker);
    }
}

void PairForces::search_cell_pair(std::uint32_t i_begin, std::uint32_t i_end, std::uint32_t j_begin,
                                  std::uint32_t j_end, bool same_cell, const Vector3& shift, std::uint8_t image_ij,
                                  std::uint8_t image_ji, PairWorker& worker) {
    const double range_squared = table_.range() * table_.range();
    const std::vector<double>& reach_squared = table_.reach_squared();
    const std::size_t drag_only = table_.batch_kinds() - 1;
    const std::vector<std::uint32_t>& order = cells_.order();
    for (std::uint32_t i = i_begin; i < i_end; ++i) {
        const double x = x_[i];
        const double y = y_[i];
        const double z = z_[i];
        for (std::uint32_t j = same_cell ? i + 1 : j_begin; j < j_end; ++j) {
            // The difference first and the shift after it: seen from j, every rounding is the exact opposite.
            const double dx = (x - x_[j]) - shift[0];
            const double dy = (y - y_[j]) - shift[1];
            const double dz = (z - z_[j]) - shift[2];
            const double distance_squared = dx * dx + dy * dy + dz * dz;
            if (!(distance_squared < range_squared)) {
                continue;
            }
            const std::uint32_t term = table_.term(species_[i], species_[j]);
            if (!(distance_squared < reach_squared[term]) || (any_frozen_ && frozen_[i] != 0 && frozen_[j] != 0) ||
                excluded(i, j)) {
                continue;
            }
            const std::size_t kind = std::min<std::size_t>(table_.kernel_of()[term], drag_only);
            PairBatch& batch = worker.batches[kind];
            const std::size_t k = batch.size;
            batch.i[k] = i;
            batch.j[k] = j;
            batch.term[k] = term;
            batch.image[k] = order[i] < order[j] ? image_ij : image_ji;
            batch.dx[k] = dx;
            batch.dy[k] = dy;
            batch.dz[k] = dz;
            batch.distance_squared[k] = distance_squared;
            if (++batch.size == batch_capacity) {
                flush(kind, worker);
            }
        }
    }
}

// Drag and noise of a batch: −γ w^D (e·v_ij) e and σ w^R ζ/√Δt e with w^R = √w^D, Español and Warren (1995).
void PairForces::evaluate_drag(const PairBatch& batch, BatchResult& result, const ForceRequest& request) const {
    const std::vector<std::uint32_t>& order = cells_.order();
    for (std::size_t k = 0; k < batch.size; ++k) {
        const PairDrag& pair = table_.drags()[batch.term[k]];
        const std::uint32_t i = batch.i[k];
        const std::uint32_t j = batch.j[k];
        result.drag[k] = 0.0;
        result.noise[k] = 0.0;
        const double distance = std::sqrt(batch.distance_squared[k]);
        // A bead and its own image, and coincident beads, define no direction that could be damped.
        if (!(pair.drag > 0.0) || !(distance < pair.cutoff) || distance == 0.0 || i == j) {
            continue;
        }
        const double closeness = 1.0 - distance / pair.cutoff;
        const double weight =
            request.weight_exponent == 2.0 ? closeness : std::pow(closeness, 0.5 * request.weight_exponent);
        const double projection =
            batch.dx[k] * (vx_[i] - vx_[j]) + batch.dy[k] * (vy_[i] - vy_[j]) + batch.dz[k] * (vz_[i] - vz_[j]);
        result.drag[k] = -pair.drag * weight * weight * projection / batch.distance_squared[k];
        if (pair.noise > 0.0) {
            const double zeta = request.gaussian_noise
                                    ? pair_noise(request.seed, request.step, order[i], order[j], batch.image[k])
                                    : word_to_noise * mix_words(words_[i], words_[j], batch.image[k]);
            result.noise[k] = pair.noise * weight * zeta * request.inverse_root_timestep / distance;
        }
    }
}

void PairForces::flush(std::size_t kind, PairWorker& worker) {
    PairBatch& batch = worker.batches[kind];
    if (batch.size == 0) {
        return;
    }
    BatchResult& result = worker.result;
    const PairKernel* kernel = table_.kernel(kind);
    if (kernel != nullptr) {
        kernel->evaluate(batch, result);
    } else {
        std::fill_n(result.energy.begin(), batch.size, 0.0);
        std::fill_n(result.conservative.begin(), batch.size, 0.0);
    }
    const bool drag = worker.request.drag && table_.has_drag();
    if (drag) {
        evaluate_drag(batch, result, worker.request);
    }
    const double scale = worker.scale;
    const double energy_scale = worker.energy_scale;
    for (std::size_t k = 0; k < batch.size; ++k) {
        const double factor = drag ? result.conservative[k] + result.drag[k] + result.noise[k] : result.conservative[k];
        const std::array<double, 3> d{batch.dx[k], batch.dy[k], batch.dz[k]};
        double largest = 0.0;
        std::array<double, 3> force{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            force[axis] = factor * d[axis] * scale;
            largest = std::max(largest, std::abs(force[axis]));
        }
        double largest_energy = 0.0;
        if (worker.request.observe) {
            const double reach = batch.distance_squared[k] * energy_scale;
            largest_energy = std::abs(result.energy[k]) * energy_scale;
            for (const double part :
                 {result.conservative[k], drag ? result.drag[k] : 0.0, drag ? result.noise[k] : 0.0}) {
                largest_energy = std::max(largest_energy, std::abs(part) * reach);
            }
        }
        if (!std::isfinite(factor) || !std::isfinite(largest_energy)) {
            largest = std::numeric_limits<double>::infinity();
        }
        worker.largest_energy = std::max(worker.largest_energy, largest_energy / largest_term);
        if (largest >= largest_term && largest / largest_term > worker.largest) {
            worker.largest = largest / largest_term;
            worker.largest_i = batch.i[k];
            worker.largest_j = batch.j[k];
            worker.largest_distance = std::sqrt(batch.distance_squared[k]);
        }
        if (largest >= largest_term || largest_energy >= largest_term) {
            continue;  // this walk is repeated on a coarser grid
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t rounded = std::llrint(force[axis]);
            sums_[3 * std::size_t{batch.i[k]} + axis] += rounded;
            sums_[3 * std::size_t{batch.j[k]} + axis] -= rounded;
        }
        if (worker.request.observe) {
            worker.energy.add(std::llrint(result.energy[k] * energy_scale));
            for (std::size_t a = 0; a < 3; ++a) {
                for (std::size_t b = 0; b < 3; ++b) {
                    const double product = d[a] * d[b] * energy_scale;
                    worker.conservative[3 * a + b].add(std::llrint(result.conservative[k] * product));
                    if (drag) {
                        worker.drag[3 * a + b].add(std::llrint(result.drag[k] * product));
                        worker.noise[3 * a + b].add(std::llrint(result.noise[k] * product));
                    }
                }
            }
        }
    }
    batch.size = 0;
}

void PairForces::report_overflow(const PairWorker& worst) const {
    const std::vector<std::uint32_t>& order = cells_.order();
    const std::uint32_t first = std::min(order[worst.largest_i], order[worst.largest_j]) + 1;
    const std::uint32_t second = std::max(order[worst.largest_i], order[worst.largest_j]) + 1;
    std::ostringstream text;
    text.precision(6);
    text << "step " << worst.request.step << ": the pair force between beads " << first << " and " << second
         << " is not finite at a distance of " << worst.largest_distance
         << "; a law that diverges at contact needs beads that do not coincide";
    throw RunFailure(text.str());
}

}  // namespace dlpoly
