// One reaction between dissolved species of a bead, of first or second order, by the exact solution of its own
// equation.
//
// With the amounts u and v of two reactants, of which a reaction takes p and q (less what it gives back), the extent
// obeys dξ/dt = k (u − pξ)(v − qξ). Since D = q u − p v does not change, u/v grows as exp(kDt), and
//
//   ξ = u v k t φ/(1 + q u k t φ),  φ = (exp(kDt) − 1)/(kDt).
//
// All species change by the same ξ times whole numbers: what the reaction conserves is conserved to round-off, and no
// amount falls below 0. First order is v = 1, q = 0; a species that meets itself is u = v, p = q.
#pragma once

#include <cstdint>
#include <vector>

namespace dlpoly {

class SpeciesReaction {
  public:
    // rate: k, 1/ps or 1/(ps amount); reactants: one or two dissolved species; change: of every dissolved species in
    // one reaction; bead_species: where it happens, −1 = in all beads. Throws std::invalid_argument for what runs away
    // in finite time.
    SpeciesReaction(double rate, std::vector<std::int32_t> reactants, std::vector<double> change,
                    std::int32_t bead_species);

    [[nodiscard]] bool happens_in(std::int32_t bead_species) const noexcept {
        return where_ < 0 || where_ == bead_species;
    }

    // ξ of a time from the amounts of a bead.
    [[nodiscard]] double extent(const double* amounts, double duration) const;

    [[nodiscard]] const std::vector<double>& change() const noexcept { return change_; }

  private:
    double rate_;
    std::size_t first_, second_;  // the same twice: a species meets itself
    bool second_order_;
    std::vector<double> change_;
    std::int32_t where_;
};

}  // namespace dlpoly
