// Angle law mmsb: MM3's stretch-bend, U = A (θ − θ0)(rij − r1)(rjk − r2).
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class StretchBendMm3Angle {
    static constexpr std::array<std::string_view, 4> names{"A", "th0", "r1", "r2"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "mmsb",
                                  .restraint_key = "-msb",
                                  .description = "MM3 stretch-bend, A (th - th0)(rij - r1)(rjk - r2)",
                                  .parameter_names = names,
                                  .energy_mask = 0b1,
                                  .degree_mask = 0b10};

    explicit StretchBendMm3Angle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        angle_ = given.any(1);
        first_ = given.any(2);
        second_ = given.any(3);
    }

    AngleValue operator()(double angle, double first, double second) const noexcept {
        const double bend = strength_ * (angle - angle_);
        const double a = first - first_;
        const double b = second - second_;
        return {bend * a * b, strength_ * a * b, bend * b, bend * a};
    }

  private:
    double strength_, angle_, first_, second_;
};

}  // namespace dlpoly::bonded
