// Bond law rhrm: a spring that pulls with constant force beyond a stretch of rc.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class RestrainedBond {
    static constexpr std::array<std::string_view, 3> names{"k", "r0", "rc"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::bond,
        .key = "rhrm",
        .restraint_key = "-rhm",
        .description = "spring, k/2 d^2 with d = r - r0 up to |d| = rc, then k rc (|d| - rc/2)",
        .parameter_names = names,
        .energy_mask = 0b1};

    explicit RestrainedBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        length_ = given.any(1);
        largest_ = given.not_negative(2);
    }

    Value operator()(double length) const noexcept {
        const double stretch = length - length_;
        const double bent = std::clamp(stretch, -largest_, largest_);
        const double beyond = std::abs(stretch) - std::abs(bent);
        return {stiffness_ * (0.5 * bent * bent + largest_ * beyond), stiffness_ * bent};
    }

  private:
    double stiffness_, length_, largest_;
};

}  // namespace dlpoly::bonded
