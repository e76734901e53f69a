// Pair law zbls: ZBL inside, Morse outside.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/law.hpp"
#include "pair/morse.hpp"
#include "pair/parameters.hpp"
#include "pair/tail.hpp"
#include "pair/zbl_switch.hpp"

namespace dlpoly::pair {

class ZblMorse {
    static constexpr std::array<std::string_view, 7> names{"Z1", "Z2", "rm", "xi", "E0", "r0", "k"};

  public:
    static constexpr LawInfo info{.key = "zbls",
                                  .description = "ZBL inside rm, Morse outside, switched over xi",
                                  .parameter_names = names,
                                  .energy_mask = 0b0010000,
                                  .drag_slot = 8,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    ZblMorse(std::span<const double> parameters, double cutoff)
        : ZblMorse(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    // DL_POLY's correction is that of Morse alone: beyond the cutoff nothing is left of ZBL's share.
    Tail tail(double cutoff) const { return integrated_tail(value_.outer(), cutoff); }

    PairValue operator()(double distance_squared) const noexcept { return value_(distance_squared); }

  private:
    ZblMorse(const Parameters& given, std::span<const double> parameters, double cutoff)
        : value_(parameters.first(2), given.not_negative(2), given.positive(3), parameters.subspan(4), cutoff) {}

    ZblSwitch<Morse> value_;
};

}  // namespace dlpoly::pair
