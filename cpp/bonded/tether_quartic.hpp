// Tether law quar: a quartic spring, U = k/2 d² + k'/3 d³ + k''/4 d⁴.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class QuarticTether {
    static constexpr std::array<std::string_view, 3> names{"k", "k'", "k''"};

  public:
    static constexpr LawInfo info{.kind = Kind::tether,
                                  .key = "quar",
                                  .restraint_key = "",
                                  .description = "quartic, k/2 d^2 + k'/3 d^3 + k''/4 d^4",
                                  .parameter_names = names,
                                  .energy_mask = 0b111};

    explicit QuarticTether(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        second_ = given.any(0);
        third_ = given.any(1);
        fourth_ = given.any(2);
    }

    Value operator()(double length) const noexcept {
        const double d = length;
        return {d * d * (0.5 * second_ + d * (third_ / 3.0 + 0.25 * fourth_ * d)),
                d * (second_ + d * (third_ + fourth_ * d))};
    }

  private:
    double second_, third_, fourth_;
};

}  // namespace dlpoly::bonded
