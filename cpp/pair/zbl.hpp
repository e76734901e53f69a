// Pair law zbl: the universal screened nuclear repulsion of Ziegler, Biersack and Littmark.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class Zbl {
    static constexpr std::array<std::string_view, 2> names{"Z1", "Z2"};

  public:
    static constexpr LawInfo info{.key = "zbl",
                                  .description = "Ziegler-Biersack-Littmark screened nuclear repulsion",
                                  .parameter_names = names,
                                  .energy_mask = 0b00,
                                  .drag_slot = 5,
                                  .soft = false,
                                  .has_tail = false,
                                  .mixable = false,
                                  .shiftable = true};

    // No long-range correction: DL_POLY's source has one, but the numbers it adds to its energies are zero, and at any
    // cutoff in use the screened repulsion is over.
    // Z are nuclear charges in e: nothing here is scaled by FIELD's energy unit.
    Zbl(std::span<const double> parameters, double cutoff) {
        const Parameters given(info, parameters, cutoff);
        const double first = given.positive(0);
        const double second = given.positive(1);
        constexpr double coulomb = 138935.4835;  // 1/(4π ε0) in internal units, DL_POLY's digits
        constexpr double bohr = 0.52917721067;   // Å
        const double screening = 0.88534 * bohr / (std::pow(first, 0.23) + std::pow(second, 0.23));
        strength_ = coulomb * first * second;
        for (std::size_t k = 0; k < rates_.size(); ++k) rates_[k] = exponents[k] / screening;
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const double distance = std::sqrt(distance_squared);
        const double inverse = 1.0 / distance;
        double screen = 0.0;
        double slope = 0.0;
        for (std::size_t k = 0; k < rates_.size(); ++k) {
            const double term = weights[k] * std::exp(-rates_[k] * distance);
            screen += term;
            slope += rates_[k] * term;
        }
        const double scale = strength_ * inverse;
        return {scale * screen, scale * (screen * inverse + slope) * inverse};
    }

  private:
    static constexpr std::array<double, 4> weights{0.18175, 0.50986, 0.28022, 0.02817};
    static constexpr std::array<double, 4> exponents{3.1998, 0.94229, 0.40290, 0.20162};

    double strength_;
    std::array<double, 4> rates_{};
};

}  // namespace dlpoly::pair
