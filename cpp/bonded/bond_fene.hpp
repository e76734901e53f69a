// Bond law fene: finitely extensible, U = −½ k R0² ln{1 − [(r − D)/R0]²}.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class FeneBond {
    static constexpr std::array<std::string_view, 3> names{"k", "R0", "D"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "fene",
                                  .restraint_key = "-fne",
                                  .description = "finitely extensible, -k R0^2/2 ln{1 - [(r - D)/R0]^2}",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .optional = 1,
                                  .limit = "it is stretched to R0 or beyond"};

    explicit FeneBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        const double largest = given.positive(1);
        given.require(std::abs(given.any(2)) <= 0.5 * largest, 2, "at most half of R0");
        offset_ = given.any(2);
        inverse_square_ = 1.0 / (largest * largest);
    }

    Value operator()(double length) const noexcept {
        const double stretch = length - offset_;
        const double rest = 1.0 - stretch * stretch * inverse_square_;
        if (!(rest > 0.0)) {
            constexpr double infinite = std::numeric_limits<double>::infinity();
            return {infinite, infinite};
        }
        return {-0.5 * stiffness_ / inverse_square_ * std::log(rest), stiffness_ * stretch / rest};
    }

  private:
    double stiffness_, offset_, inverse_square_;
};

}  // namespace dlpoly::bonded
