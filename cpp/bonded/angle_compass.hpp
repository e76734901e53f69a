// Angle law cmps: COMPASS, all cross terms: U = A (rij − r1)(rjk − r2) + (θ − θ0)[B (rij − r1) + C (rjk − r2)].
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class CompassAngle {
    static constexpr std::array<std::string_view, 6> names{"A", "B", "C", "th0", "r1", "r2"};

  public:
    static constexpr LawInfo info{
        .kind = Kind::angle,
        .key = "cmps",
        .restraint_key = "-cmp",
        .description = "COMPASS cross terms, A (rij - r1)(rjk - r2) + (th - th0)[B (rij - r1) + C (rjk - r2)]",
        .parameter_names = names,
        .energy_mask = 0b111,
        .degree_mask = 0b1000};

    explicit CompassAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stretch_ = given.any(0);
        bend_first_ = given.any(1);
        bend_second_ = given.any(2);
        angle_ = given.any(3);
        first_ = given.any(4);
        second_ = given.any(5);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double bend = angle - angle_;
        const double a = first - first_;
        const double b = second - second_;
        const double pull = bend_first_ * a + bend_second_ * b;
        return {stretch_ * a * b + bend * pull, pull, stretch_ * b + bend_first_ * bend,
                stretch_ * a + bend_second_ * bend};
    }

  private:
    double stretch_, bend_first_, bend_second_, angle_, first_, second_;
};

}  // namespace dlpoly::bonded
