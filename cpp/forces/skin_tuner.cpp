// The skin of the pair list (see skin_tuner.hpp).
#include "forces/skin_tuner.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace dlpoly {

namespace {

// Time for a pair that is in the list but beyond its reach, over that for a pair within it. A rough number suffices:
// near the best skin the cost is flat.
constexpr double excess_cost = 0.35;

constexpr std::array<double, 14> shares{0.0,  0.04, 0.06, 0.08, 0.10, 0.12, 0.15,
                                        0.18, 0.22, 0.27, 0.33, 0.40, 0.50, 0.60};

double cube(double x) { return x * x * x; }

// Follows a fall at once and a rise slowly: other programs on the machine only ever lengthen a measured time.
void follow(double& value, double measured, bool first) {
    value = first || measured < value ? measured : value + 0.1 * (measured - value);
}

}  // namespace

void SkinTuner::built(double range, double skin, double seconds) noexcept {
    range_ = range;
    built_share_ = skin / range;
    follow(build_seconds_, seconds / cube(1.0 + built_share_), !measured_);
}

void SkinTuner::walked(const ListWork& work) noexcept {
    const auto accepted = static_cast<double>(work.accepted);
    const auto excess = static_cast<double>(work.entries - work.accepted);
    if (work.accepted > 0) {
        follow(walk_seconds_, work.seconds * accepted / (accepted + excess_cost * excess), !measured_);
        measured_ = true;
    }
}

double SkinTuner::cost(double share) const noexcept {
    const double growth = cube(1.0 + share);
    const double steps = share > 0.0 && speed_ > 0.0 ? std::floor(0.5 * share / speed_) + 1.0 : share > 0.0 ? 1e9 : 1.0;
    return build_seconds_ * growth / steps + walk_seconds_ * (1.0 + excess_cost * (growth - 1.0));
}

void SkinTuner::given_up(double displacement, std::int64_t evaluations) noexcept {
    if (!measured_ || evaluations < 1 || !std::isfinite(displacement)) {
        return;
    }
    speed_ = displacement / range_ / static_cast<double>(evaluations);
    const double* best =
        std::min_element(shares.begin(), shares.end(), [this](double a, double b) { return cost(a) < cost(b); });
    // A change of the skin can change the grid of cells, which costs more than it brings when the gain is small.
    if (cost(*best) < 0.97 * cost(share_)) {
        share_ = *best;
    }
}

}  // namespace dlpoly
