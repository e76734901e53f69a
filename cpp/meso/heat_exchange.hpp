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
// Beads whose temperature is held have no bound to what they give and take; it is counted in State::heat_supplied.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "forces/exclusions.hpp"
#include "meso/bead_process.hpp"
#include "meso/heat_pairs.hpp"
#include "sweep/pair_rows.hpp"

namespace dlpoly {

class HeatExchange final : public BeadProcess {
  public:
    HeatExchange(const PairTable& table, std::shared_ptr<const HeatPairs> pairs);

    void advance(State& state, Forces& forces, const StepSettings& settings) override;

  private:
    struct Bead {
        double temperature;
        double capacity;
        double inverse_capacity;  // 0 where the temperature is held
        double gained;            // by beads whose temperature is held
        std::uint32_t word;
    };

    void gather(const State& state, const StepSettings& settings, int threads);
    void spread(State& state, int threads) const;
    void exchange(const PairRows::Row& row, std::size_t k, const StepSettings& settings, std::uint64_t step);
    [[nodiscard]] double noise(const PairRows::Row& row, std::size_t k, const StepSettings& settings,
                               std::uint64_t step) const;

    std::shared_ptr<const HeatPairs> pairs_;
    Exclusions none_;  // heat also flows between bonded beads that have no pair forces
    PairRows rows_;
    std::vector<Bead> beads_;  // sorted
};

}  // namespace dlpoly
