// Pair law m126: 12-6 tapered to zero between ri and the cutoff.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/taper.hpp"
#include "pair/twelve_six.hpp"

namespace dlpoly::pair {

class TaperedTwelveSix {
    static constexpr std::array<std::string_view, 3> names{"A", "B", "ri"};

  public:
    static constexpr LawInfo info{.key = "m126",
                                  .description = "12-6 with the Mei-Davenport-Fernando taper from ri to the cutoff",
                                  .parameter_names = names,
                                  .energy_mask = 0b011,
                                  .drag_slot = 0,
                                  .soft = false,
                                  .has_tail = false,
                                  .mixable = true,
                                  .shiftable = false};

    TaperedTwelveSix(std::span<const double> parameters, double cutoff)
        : TaperedTwelveSix(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return value_(distance_squared); }

  private:
    TaperedTwelveSix(const Parameters& given, std::span<const double> parameters, double cutoff)
        : value_(parameters.first(2), start(given, cutoff), cutoff) {}

    static double start(const Parameters& given, double cutoff) {
        given.require(given.not_negative(2) < cutoff, 2, "less than the cutoff");
        return given.any(2);
    }

    Taper<TwelveSix> value_;
};

}  // namespace dlpoly::pair
