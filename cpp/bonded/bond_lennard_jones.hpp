// Bond law lj: Lennard-Jones, U = 4 eps [(sig/r)¹² − (sig/r)⁶].
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class LennardJonesBond {
    static constexpr std::array<std::string_view, 2> names{"eps", "sig"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "lj",
                                  .restraint_key = "-lj",
                                  .description = "Lennard-Jones, 4 eps [(sig/r)^12 - (sig/r)^6]",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .limit = "the beads coincide"};

    explicit LennardJonesBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        depth_ = given.any(0);
        size_ = given.any(1);
    }

    Value operator()(double length) const noexcept {
        const double inverse = 1.0 / length;
        const double ratio = size_ * inverse;
        const double square = ratio * ratio;
        const double sixth = square * square * square;
        return {4.0 * depth_ * sixth * (sixth - 1.0), 24.0 * depth_ * sixth * (1.0 - 2.0 * sixth) * inverse};
    }

  private:
    double depth_, size_;
};

}  // namespace dlpoly::bonded
