// Angle law stst: U = A (rij − r1)(rjk − r2), whatever the angle.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class StretchStretchAngle {
    static constexpr std::array<std::string_view, 3> names{"A", "r1", "r2"};

  public:
    static constexpr LawInfo info{.kind = Kind::angle,
                                  .key = "stst",
                                  .restraint_key = "-sts",
                                  .description = "stretch-stretch, A (rij - r1)(rjk - r2)",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit StretchStretchAngle(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        strength_ = given.any(0);
        first_ = given.any(1);
        second_ = given.any(2);
    }

    AngleValue operator()(double /*angle*/, double first, double second) const noexcept {
        const double a = first - first_;
        const double b = second - second_;
        return {strength_ * a * b, 0.0, strength_ * b, strength_ * a};
    }

  private:
    double strength_, first_, second_;
};

}  // namespace dlpoly::bonded
