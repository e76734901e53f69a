// Heat between neighbours: pair after pair, what one bead gains the other loses.
//
// The difference δ = T_j − T_i of a pair relaxes with the rate r = k w_T² (1/C_i + 1/C_j)/(T_i T_j), k = C_i C_j κ T̄²,
// and its fluctuations are renewed at the same rate, so that over the timestep h with frozen coefficients bead i gains
//
//   ΔE = c δ (1 − e^{−rh}) + √(c T_i T_j (1 − e^{−2rh})) ξ + ½ h w_T² (1/C_i − 1/C_j) dk/dT̄,   1/c = 1/C_i + 1/C_j.
//
// For short steps this is k w_T² (1/T_i − 1/T_j) h + √(2 k h) w_T ξ of Li et al. (2014); for any step it neither
// overshoots nor changes the size of equilibrium fluctuations. The last term is Itô's, which unequal heat capacities
// need for the distribution ∏ (C_i T_i)^{C_i} at equilibrium. Energies that would become negative are reflected at 0.
//
// Weights and noise of a pair do not depend on temperatures and are made for a whole row of cells at once; pairs that
// share no bead then exchange together, in rounds that leave every bead the order of its pairs (pair_rounds.hpp).
//
// Beads whose temperature is held have no bound to what they give and take; it is counted in State::heat_supplied.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "forces/exclusions.hpp"
#include "meso/bead_process.hpp"
#include "meso/heat_exchange_loops.hpp"
#include "meso/heat_pairs.hpp"
#include "sweep/pair_rounds.hpp"
#include "sweep/pair_rows.hpp"

namespace dlpoly {

class HeatExchange final : public BeadProcess {
  public:
    HeatExchange(const PairTable& table, std::shared_ptr<const HeatPairs> pairs);

    void advance(State& state, Forces& forces, const StepSettings& settings) override;

  private:
    // The pairs of a row, round after round.
    struct Turns {
        PairRounds rounds;
        std::vector<std::uint32_t> first, second, term, image;
        std::vector<std::int32_t> word;
        std::vector<double> squared, weight, normal;
    };

    void gather(const State& state, const StepSettings& settings, int threads);
    void spread(State& state, int threads) const;
    void arrange(const PairRows::Row& row, Turns& turns) const;
    void make_normals(Turns& turns, const StepSettings& settings, std::uint64_t step) const;
    void exchange(const PairRows::Row& row, Turns& turns, const StepSettings& settings, std::uint64_t step);
    // Gives a pair its gain where a temperature is held or an energy has to be reflected.
    void give(std::uint32_t first, std::uint32_t second, double gain);

    std::shared_ptr<const HeatPairs> pairs_;
    const HeatExchangeLoops* loops_;
    Exclusions none_;  // heat also flows between bonded beads that have no pair forces
    PairRows rows_;
    bool one_term_;
    bool quadratic_ = true;  // all s_T are 2
    // Of beads, sorted.
    std::vector<double> temperature_;
    std::vector<double> capacity_;
    std::vector<double> inverse_capacity_;  // 0 where the temperature is held
    std::vector<double> gained_;            // by beads whose temperature is held
    std::vector<std::uint32_t> word_;
    std::vector<Turns> turns_;  // one a thread
};

}  // namespace dlpoly
