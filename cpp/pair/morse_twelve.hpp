// Pair law mstw: Morse plus c/r¹², which keeps beads apart where Morse alone is finite.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/morse.hpp"
#include "pair/parameters.hpp"

namespace dlpoly::pair {

class MorseTwelve {
    static constexpr std::array<std::string_view, 4> names{"E0", "r0", "k", "c"};

  public:
    static constexpr LawInfo info{.key = "mstw",
                                  .description = "Morse + c/r^12",
                                  .parameter_names = names,
                                  .energy_mask = 0b1001,
                                  .drag_slot = 5,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    MorseTwelve(std::span<const double> parameters, double cutoff)
        : MorseTwelve(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept {
        const PairValue morse = morse_(distance_squared);
        const double inverse_square = 1.0 / distance_squared;
        const double inverse_sixth = inverse_square * inverse_square * inverse_square;
        const double repulsive = repulsion_ * inverse_sixth * inverse_sixth;
        return {morse.energy + repulsive, morse.force_over_r + 12.0 * repulsive * inverse_square};
    }

  private:
    MorseTwelve(const Parameters& given, std::span<const double> parameters, double cutoff)
        : morse_(parameters.first(3), cutoff), repulsion_(given.any(3)) {}

    Morse morse_;
    double repulsion_;
};

}  // namespace dlpoly::pair
