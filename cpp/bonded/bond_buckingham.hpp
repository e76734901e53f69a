// Bond law buck: Buckingham, U = A exp(−r/rho) − C/r⁶.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class BuckinghamBond {
    static constexpr std::array<std::string_view, 3> names{"A", "rho", "C"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "buck",
                                  .restraint_key = "-bck",
                                  .description = "Buckingham, A exp(-r/rho) - C/r^6",
                                  .parameter_names = names,
                                  .energy_mask = 0b101,
                                  .limit = "the beads coincide"};

    explicit BuckinghamBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        // As in DL_POLY, both may be zero: the exponential is then absent.
        const bool absent = given.any(0) == 0.0 && given.any(1) == 0.0;
        inverse_range_ = absent ? 1.0 : 1.0 / given.positive(1);
        attraction_ = given.any(2);
    }

    Value operator()(double length) const noexcept {
        const double wall = strength_ * std::exp(-length * inverse_range_);
        if (attraction_ == 0.0) return {wall, -wall * inverse_range_};
        const double inverse = 1.0 / length;
        const double square = inverse * inverse;
        const double tail = attraction_ * square * square * square;
        return {wall - tail, 6.0 * tail * inverse - wall * inverse_range_};
    }

  private:
    double strength_, inverse_range_, attraction_;
};

}  // namespace dlpoly::bonded
