// Transport of dissolved species in a step: sources and reactions for half of it, exchange between beads, reactions and
// sources in the opposite order for the other half. The sweep over pairs goes forward in odd steps and backward in even
// ones. All parts are exact by themselves, so that the whole is of second order and keeps amounts from 0 on for any Δt.
#pragma once

#include <cstdint>
#include <vector>

#include "meso/bead_process.hpp"
#include "meso/region.hpp"
#include "meso/species_exchange.hpp"
#include "meso/species_reaction.hpp"

namespace dlpoly {

class SpeciesTransport : public BeadProcess {
  public:
    SpeciesTransport(std::int32_t bead_species, std::int32_t dissolved);

    [[nodiscard]] SpeciesExchange& exchange() noexcept { return exchange_; }
    // rate: amount a bead and time. A sink, which has a negative one, takes no more than there is.
    void add_source(std::int32_t dissolved, double rate, const Region& region);
    void add_reaction(SpeciesReaction reaction) { reactions_.push_back(std::move(reaction)); }
    void add_hold(std::int32_t bead_species, std::int32_t dissolved, double value);

    void advance(State& state, Forces& forces, const StepSettings& settings) override;

    // What sources, reactions and held beads have given by dissolved species, and below it what these sums have lost to
    // rounding: (6, species).
    [[nodiscard]] const ArrayXN& tally() const noexcept { return tally_; }
    void set_tally(const ArrayXN& tally);

  private:
    struct Source {
        std::size_t dissolved;
        double rate;
        Region region;
    };
    enum Row : Eigen::Index { from_sources, from_reactions, from_held, rows };
    struct Gains;

    void local(State& state, double duration, bool backward);
    void in_bead(State& state, std::size_t bead, double duration, bool backward, Gains& gains) const;
    void add_sources(const State& state, std::size_t bead, double duration, double* amounts, Gains& gains) const;
    void react(std::int32_t species, double duration, bool backward, double* amounts, Gains& gains) const;
    void count(Row row, std::size_t dissolved, double amount);
    void check(const State& state) const;

    std::size_t count_;  // of dissolved species
    SpeciesExchange exchange_;
    std::vector<Source> sources_;
    std::vector<SpeciesReaction> reactions_;
    std::vector<double> hold_;  // value by bead species and dissolved species; negative: none
    bool any_hold_ = false;
    ArrayXN tally_;
};

}  // namespace dlpoly
