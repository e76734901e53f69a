// Bond law mmst: MM3, U = k d² [1 − 2.55 d + (7/12) 2.55² d²] with d = r − r0.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class Mm3Bond {
    static constexpr std::array<std::string_view, 2> names{"k", "r0"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "mmst",
                                  .restraint_key = "-mst",
                                  .description = "MM3, k d^2 [1 - 2.55 d + (7/12) 2.55^2 d^2], d = r - r0",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit Mm3Bond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        length_ = given.any(1);
    }

    Value operator()(double length) const noexcept {
        constexpr double cubic = 2.55;
        constexpr double quartic = 7.0 / 12.0 * cubic * cubic;
        const double d = length - length_;
        return {stiffness_ * d * d * (1.0 - d * (cubic - quartic * d)),
                stiffness_ * d * (2.0 - d * (3.0 * cubic - 4.0 * quartic * d))};
    }

  private:
    double stiffness_, length_;
};

}  // namespace dlpoly::bonded
