// Tether law rhrm: a spring that pulls with constant force beyond rc.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class RestrainedTether {
    static constexpr std::array<std::string_view, 2> names{"k", "rc"};

  public:
    static constexpr LawInfo info{.kind = Kind::tether,
                                  .key = "rhrm",
                                  .restraint_key = "",
                                  .description = "spring, k/2 d^2 up to d = rc, then k rc (d - rc/2)",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit RestrainedTether(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        largest_ = given.not_negative(1);
    }

    Value operator()(double length) const noexcept {
        const double bent = std::min(length, largest_);
        return {stiffness_ * (0.5 * bent * bent + largest_ * (length - bent)), stiffness_ * bent};
    }

  private:
    double stiffness_, largest_;
};

}  // namespace dlpoly::bonded
