// Bond law harm: a spring, U = ½ k (r − r0)².
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "bonded/law.hpp"
#include "bonded/parameters.hpp"

namespace dlpoly::bonded {

class HarmonicBond {
    static constexpr std::array<std::string_view, 2> names{"k", "r0"};

  public:
    static constexpr LawInfo info{.kind = Kind::bond,
                                  .key = "harm",
                                  .restraint_key = "-hrm",
                                  .description = "spring, k/2 (r - r0)^2",
                                  .parameter_names = names,
                                  .energy_mask = 0b1};

    explicit HarmonicBond(std::span<const double> numbers) {
        const Parameters given(info, numbers);
        stiffness_ = given.any(0);
        length_ = given.any(1);
    }

    Value operator()(double length) const noexcept {
        const double stretch = length - length_;
        return {0.5 * stiffness_ * stretch * stretch, stiffness_ * stretch};
    }

  private:
    double stiffness_, length_;
};

}  // namespace dlpoly::bonded
