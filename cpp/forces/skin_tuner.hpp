// Chooses the skin of the pair list by what building it and walking it have cost. The clock may be asked here, because
// the sums over pairs are exact: a list changes when things are computed, never a bit of the results.
#pragma once

#include <cstdint>

namespace dlpoly {

// What one walk over the list met.
struct ListWork {
    double seconds = 0.0;
    std::int64_t entries = 0;   // pairs in the list
    std::int64_t accepted = 0;  // pairs within their reach
};

class SkinTuner {
  public:
    // The skin for the next list of pairs up to `range`; 0: a list for one evaluation only.
    [[nodiscard]] double skin(double range) const noexcept { return share_ * range; }

    // A list with this skin was built in `seconds`.
    void built(double range, double skin, double seconds) noexcept;
    // It was walked.
    void walked(const ListWork& work) noexcept;
    // It is given up: after `evaluations` its fastest bead had moved by `displacement`. Chooses the next skin.
    void given_up(double displacement, std::int64_t evaluations) noexcept;

  private:
    [[nodiscard]] double cost(double share) const noexcept;

    double share_ = 0.15;       // skin over range
    double built_share_ = 0.0;  // of the present list
    double range_ = 1.0;
    double build_seconds_ = 0.0;   // of a list without skin
    double walk_seconds_ = 0.0;    // of a list without skin
    double excess_seconds_ = 0.0;  // for as many pairs beyond the reach as there are within it
    double speed_ = 0.0;           // displacement of the fastest bead in one evaluation, over range
    bool measured_ = false;
};

}  // namespace dlpoly
