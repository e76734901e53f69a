// Pair law mdpd: what many-body DPD keeps of a pair's own, U = ½ A rc (1 − r/rc)², usually an attraction; the part that
// depends on local densities is cpp/meso/many_body.hpp.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/dpd.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class ManyBodyDpd {
    static constexpr std::array<std::string_view, 6> names{"A", "B", "n", "m", "rc", "rd"};

  public:
    static constexpr LawInfo info{.key = "mdpd",
                                  .description = "many-body DPD, A rc/2 (1 - r/rc)^2 and B rho^m/m of local densities",
                                  .parameter_names = names,
                                  .energy_mask = 0b000011,
                                  .drag_slot = 7,
                                  .soft = true,
                                  .has_tail = false,
                                  .mixable = true,
                                  .shiftable = false};

    ManyBodyDpd(std::span<const double> parameters, double cutoff) : repulsion_(checked(parameters, cutoff), cutoff) {}

    double range() const noexcept { return repulsion_.range(); }

    PairValue operator()(double distance_squared) const noexcept { return repulsion_(distance_squared); }

  private:
    // A and r_c of the part between pairs, once all seven numbers are in order.
    static std::array<double, 2> checked(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        given.not_negative(1);
        given.require(given.any(2) >= 2.0, 2, "2 or more");
        given.require(given.any(3) >= 1.0 || given.any(3) == 0.0, 3, "1 or more, or 0 where the species say it");
        const double range = given.positive(4);
        given.positive(5);
        given.require(given.any(5) <= range, 5, "at most rc");
        return {given.any(0), range};
    }

    Dpd repulsion_;
};

}  // namespace dlpoly::pair
