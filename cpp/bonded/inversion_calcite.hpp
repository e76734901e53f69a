// Inversion law calc: U = A u² + B u⁴ of the distance u of the centre from the plane of the other three.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class CalciteInversion {
    static constexpr std::array<std::string_view, 2> names{"A", "B"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::inversion,
        .key = "calc",
        .restraint_key = "-clc",
        .description = "calcite, A u^2 + B u^4, u = distance of the centre from the plane of the others",
        .parameter_names = names,
        .energy_mask = 0b11,
        .height = true};

    explicit CalciteInversion(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        second_ = given.any(0);
        fourth_ = given.any(1);
    }

    Value operator()(double height) const noexcept {
        const double square = height * height;
        return {square * (second_ + fourth_ * square), height * (2.0 * second_ + 4.0 * fourth_ * square)};
    }

  private:
    double second_, fourth_;
};

}  // namespace dlpoly::bonded
