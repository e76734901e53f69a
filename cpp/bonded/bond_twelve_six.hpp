// Bond law 12-6: 12-6, U = A/r¹² − B/r⁶.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class TwelveSixBond {
    static constexpr std::array<std::string_view, 2> names{"A", "B"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "12-6",
                                  .restraint_key = "-126",
                                  .description = "12-6, A/r^12 - B/r^6",
                                  .parameter_names = names,
                                  .energy_mask = 0b11,
                                  .limit = "the beads coincide"};

    explicit TwelveSixBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        repulsion_ = given.any(0);
        attraction_ = given.any(1);
    }

    Value operator()(double length) const noexcept {
        const double inverse = 1.0 / length;
        const double square = inverse * inverse;
        const double sixth = square * square * square;
        const double outer = repulsion_ * sixth * sixth;
        const double inner = attraction_ * sixth;
        return {outer - inner, (6.0 * inner - 12.0 * outer) * inverse};
    }

  private:
    double repulsion_, attraction_;
};

}  // namespace dlpoly::bonded
