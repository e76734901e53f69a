// Pair law zblb: ZBL inside, Buckingham outside.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "pair/buckingham.hpp"
#include "pair/law.hpp"
#include "pair/parameters.hpp"
#include "pair/tail.hpp"
#include "pair/zbl_switch.hpp"

namespace dlpoly::pair {

class ZblBuckingham {
    static constexpr std::array<std::string_view, 7> names{"Z1", "Z2", "rm", "xi", "A", "rho", "C"};

  public:
    static constexpr LawInfo info{.key = "zblb",
                                  .description = "ZBL inside rm, Buckingham outside, switched over xi",
                                  .parameter_names = names,
                                  .energy_mask = 0b1010000,
                                  .drag_slot = 8,
                                  .soft = false,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    ZblBuckingham(std::span<const double> parameters, double cutoff)
        : ZblBuckingham(Parameters(info, parameters, cutoff), parameters, cutoff) {}

    double range() const noexcept { return 0.0; }

    // DL_POLY's correction is that of Buckingham alone (here with its exponential): beyond the cutoff nothing is left
    // of ZBL's share.
    Tail tail(double cutoff) const { return integrated_tail(value_.outer(), cutoff); }

    PairValue operator()(double distance_squared) const noexcept { return value_(distance_squared); }

  private:
    ZblBuckingham(const Parameters& given, std::span<const double> parameters, double cutoff)
        : value_(parameters.first(2), given.not_negative(2), given.positive(3), parameters.subspan(4), cutoff) {}

    ZblSwitch<Buckingham> value_;
};

}  // namespace dlpoly::pair
