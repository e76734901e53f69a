// Transport of dissolved species in a step (see species_transport.hpp).
#include "meso/species_transport.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/failure.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

// Beads whose gains are added up before they meet those of others: sums do not depend on threads.
constexpr std::size_t block_beads = 1024;

}  // namespace

// What beads gained by row of the tally and dissolved species.
struct SpeciesTransport::Gains {
    explicit Gains(std::size_t species) : amount(static_cast<std::size_t>(rows) * species, 0.0), count(species) {}

    void add(Row row, std::size_t dissolved, double gained) {
        amount[static_cast<std::size_t>(row) * count + dissolved] += gained;
    }

    std::vector<double> amount;
    std::size_t count;
};

SpeciesTransport::SpeciesTransport(std::int32_t bead_species, std::int32_t dissolved)
    : count_(static_cast<std::size_t>(dissolved)),
      exchange_(bead_species, dissolved),
      hold_(static_cast<std::size_t>(bead_species) * count_, -1.0),
      tally_(ArrayXN::Zero(2 * rows, dissolved)) {}

void SpeciesTransport::add_source(std::int32_t dissolved, double rate, const Region& region) {
    sources_.push_back({static_cast<std::size_t>(dissolved), rate, region});
}

void SpeciesTransport::add_hold(std::int32_t bead_species, std::int32_t dissolved, double value) {
    hold_[static_cast<std::size_t>(bead_species) * count_ + static_cast<std::size_t>(dissolved)] = value;
    exchange_.set_held(bead_species, dissolved);
    any_hold_ = true;
}

void SpeciesTransport::set_tally(const ArrayXN& tally) {
    if (tally.rows() != tally_.rows() || tally.cols() != tally_.cols()) {
        throw std::invalid_argument("the tally is of other dissolved species");
    }
    tally_ = tally;
}

void SpeciesTransport::add_sources(const State& state, std::size_t bead, double duration, double* amounts,
                                   Gains& gains) const {
    const Vector3 position = state.particles.position.row(static_cast<Eigen::Index>(bead)).transpose();
    for (const Source& source : sources_) {
        if (source.region.contains(state.box, position, state.particles.species[bead])) {
            const double gained = std::max(source.rate * duration, -amounts[source.dissolved]);
            amounts[source.dissolved] += gained;
            gains.add(from_sources, source.dissolved, gained);
        }
    }
}

void SpeciesTransport::react(std::int32_t species, double duration, bool backward, double* amounts,
                             Gains& gains) const {
    for (std::size_t turn = 0; turn < reactions_.size(); ++turn) {
        const SpeciesReaction& reaction = reactions_[backward ? reactions_.size() - 1 - turn : turn];
        if (!reaction.happens_in(species)) {
            continue;
        }
        const double extent = reaction.extent(amounts, duration);
        for (std::size_t s = 0; s < count_; ++s) {
            const double gained = reaction.change()[s] * extent;
            amounts[s] += gained;
            gains.add(from_reactions, s, gained);
        }
    }
}

void SpeciesTransport::in_bead(State& state, std::size_t bead, double duration, bool backward, Gains& gains) const {
    double* amounts = state.particles.concentration.data() + bead * count_;
    const std::int32_t species = state.particles.species[bead];
    if (backward) {
        react(species, duration, true, amounts, gains);
        add_sources(state, bead, duration, amounts, gains);
    } else {
        add_sources(state, bead, duration, amounts, gains);
        react(species, duration, false, amounts, gains);
    }
    if (!any_hold_) {
        return;
    }
    for (std::size_t s = 0; s < count_; ++s) {
        const double value = hold_[static_cast<std::size_t>(species) * count_ + s];
        if (value >= 0.0) {
            gains.add(from_held, s, value - amounts[s]);
            amounts[s] = value;
        }
    }
}

void SpeciesTransport::count(Row row, std::size_t dissolved, double amount) {
    // Neumaier's sum: what one addition loses is kept.
    const auto column = static_cast<Eigen::Index>(dissolved);
    double& sum = tally_(row, column);
    const double next = sum + amount;
    tally_(row + rows, column) += std::abs(sum) >= std::abs(amount) ? (sum - next) + amount : (amount - next) + sum;
    sum = next;
}

void SpeciesTransport::local(State& state, double duration, bool backward) {
    if (sources_.empty() && reactions_.empty() && !any_hold_) {
        return;
    }
    const auto beads = static_cast<std::size_t>(state.particles.count());
    const std::size_t blocks = (beads + block_beads - 1) / block_beads;
    std::vector<Gains> gains(blocks, Gains(count_));
#ifdef _OPENMP
    [[maybe_unused]] const int threads =
        static_cast<int>(std::clamp<std::size_t>(blocks, 1, static_cast<std::size_t>(thread_limit())));
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (std::size_t block = 0; block < blocks; ++block) {
        const std::size_t end = std::min(beads, (block + 1) * block_beads);
        for (std::size_t bead = block * block_beads; bead < end; ++bead) {
            in_bead(state, bead, duration, backward, gains[block]);
        }
    }
    for (const Gains& one : gains) {
        for (Eigen::Index row = 0; row < rows; ++row) {
            for (std::size_t s = 0; s < count_; ++s) {
                count(static_cast<Row>(row), s, one.amount[static_cast<std::size_t>(row) * count_ + s]);
            }
        }
    }
}

void SpeciesTransport::check(const State& state) const {
    const ArrayXN& amounts = state.particles.concentration;
    if (amounts.allFinite()) {
        return;
    }
    for (Eigen::Index bead = 0; bead < amounts.rows(); ++bead) {
        for (Eigen::Index s = 0; s < amounts.cols(); ++s) {
            if (!std::isfinite(amounts(bead, s))) {
                throw RunFailure("step " + std::to_string(state.step) + ": the concentration of dissolved species " +
                                 std::to_string(s + 1) + " in bead " + std::to_string(bead + 1) +
                                 " is not a number any more; a reaction or a source grows without bound");
            }
        }
    }
}

void SpeciesTransport::advance(State& state, Forces& forces, const StepSettings& settings) {
    if (static_cast<std::size_t>(state.particles.concentration.cols()) != count_ ||
        state.particles.concentration.rows() != state.particles.count()) {
        throw RunFailure("step " + std::to_string(state.step) + ": the beads carry other dissolved species than flow");
    }
    const double half = 0.5 * settings.timestep;
    local(state, half, false);
    std::vector<double> outflow(count_, 0.0);
    exchange_.sweep(state, forces.pairs().table(), settings, settings.timestep, state.step % 2 == 0, outflow);
    for (std::size_t s = 0; s < count_; ++s) {
        count(from_held, s, outflow[s]);
    }
    local(state, half, true);
    check(state);
}

}  // namespace dlpoly
