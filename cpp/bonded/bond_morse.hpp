// Bond law mors: Morse, U = E0 {[1 − exp(−k (r − r0))]² − 1}.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class MorseBond {
    static constexpr std::array<std::string_view, 3> names{"E0", "r0", "k"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "mors",
                                  .restraint_key = "-mrs",
                                  .description = "Morse, E0 {[1 - exp(-k (r - r0))]^2 - 1}",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit MorseBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        depth_ = given.any(0);
        length_ = given.any(1);
        steepness_ = given.any(2);
    }

    Value operator()(double length) const noexcept {
        const double decay = std::exp(-steepness_ * (length - length_));
        const double rest = 1.0 - decay;
        return {depth_ * (rest * rest - 1.0), 2.0 * depth_ * steepness_ * rest * decay};
    }

  private:
    double depth_, length_, steepness_;
};

}  // namespace dlpoly::bonded
