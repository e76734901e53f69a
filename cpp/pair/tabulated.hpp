// Pair law tab: a cubic Hermite curve through the values of a TABLE file.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pair/arithmetic.hpp"
#include "pair/law.hpp"
#include "pair/tail.hpp"

namespace dlpoly::pair {

// One pair's block of a TABLE file in internal units; entry k belongs to r = (k + 1) · spacing.
struct Table {
    double spacing = 0.0;
    std::vector<double> energy;
    std::vector<double> virial;  // G = −r dU/dr
    Tail tail;                   // the corrections of the block's heading, zero where the file gives none
};

// The curve has U and dU/dr = −G/r at the nodes, and the force is exactly its derivative, so that energy is conserved
// whatever the spacing; DL_POLY interpolates U and G separately, which agrees only to the order of the spacing.
// Below the first node U continues along its tangent: finite, with the table's last known force, so that beads of a
// soft table may coincide; a hard table ends in a force that keeps beads away from there.
class Tabulated {
    struct Node {
        double energy;
        double slope;  // dU/dr · spacing
    };

    // The curve without the ownership of its nodes.
    struct Curve {
        const Node* nodes = nullptr;
        double inverse_spacing = 0.0;
        double last_interval = 0.0;

        PairValue operator()(double distance_squared) const noexcept {
            const double distance = std::sqrt(distance_squared);
            const double position = distance * inverse_spacing - 1.0;  // in spacings from the first node
            // Written so that a distance that is not a number reads the last interval, not memory outside the table.
            // The 32-bit index and the plain selects let loops over the curve be vectorised.
            const double left = std::floor(position);
            const double capped = left < last_interval ? left : last_interval;
            const double lower = capped > 0.0 ? capped : 0.0;
            const auto interval = static_cast<std::int32_t>(lower);
            const Node a = nodes[interval];
            const Node b = nodes[interval + 1];
            const double t = position > lower ? position - lower : 0.0;
            const double below = position < 0.0 ? position : 0.0;
            // U = U_a + t (s_a + t (c2 + t c3)), slopes per spacing; both derivatives match at both ends.
            const double rise = b.energy - a.energy;
            const double quadratic = 3.0 * rise - 2.0 * a.slope - b.slope;
            const double cubic = a.slope + b.slope - 2.0 * rise;
            const double energy = a.energy + t * (a.slope + t * (quadratic + t * cubic)) + below * a.slope;
            const double slope = a.slope + t * (2.0 * quadratic + 3.0 * t * cubic);
            return {energy, -slope * inverse_spacing * inverse_or_zero(distance)};
        }
    };

  public:
    static constexpr LawInfo info{.key = "tab",
                                  .description = "tabulated, from the TABLE file",
                                  .parameter_names = {},
                                  .energy_mask = 0,
                                  .drag_slot = 1,
                                  .soft = true,
                                  .has_tail = true,
                                  .mixable = false,
                                  .shiftable = true};

    static Tabulated make(const std::shared_ptr<const Table>& table, double cutoff) {
        if (!table) throw std::invalid_argument("pair law tab: the values of its table are missing");
        return Tabulated(table, cutoff);
    }

    double range() const noexcept { return 0.0; }

    PairValue operator()(double distance_squared) const noexcept { return curve_(distance_squared); }

    Curve evaluator() const noexcept { return curve_; }

    Tail tail(double /*cutoff*/) const noexcept { return tail_; }

  private:
    Tabulated(const std::shared_ptr<const Table>& table, double cutoff) {
        const std::size_t count = table->energy.size();
        const double spacing = table->spacing;
        if (!(std::isfinite(spacing) && spacing > 0.0)) {
            throw std::invalid_argument("pair law tab: the table's spacing must be a positive number");
        }
        if (count >= (std::size_t{1} << 31)) {
            throw std::invalid_argument("pair law tab: a table has fewer than 2^31 points");
        }
        if (count < 2 || table->virial.size() != count) {
            throw std::invalid_argument(
                "pair law tab: a table needs at least two points, each with U and G = -r dU/dr");
        }
        const double end = spacing * static_cast<double>(count);
        // Spacings are printed with few digits, so the last node may miss the cutoff by rounding.
        if (!(std::isfinite(cutoff) && cutoff > 0.0) || end < cutoff * (1.0 - 1e-8)) {
            std::ostringstream text;
            text << "pair law tab: the cutoff must be a positive number within the table, which ends at " << end
                 << ", not " << cutoff;
            throw std::invalid_argument(text.str());
        }
        auto nodes = std::make_shared<std::vector<Node>>();
        nodes->reserve(count);
        for (std::size_t k = 0; k < count; ++k) {
            if (!std::isfinite(table->energy[k]) || !std::isfinite(table->virial[k])) {
                throw std::invalid_argument("pair law tab: the table's U and G must be finite, entry " +
                                            std::to_string(k + 1) + " is not");
            }
            // slope · spacing = −G/r · spacing = −G/(k + 1)
            nodes->push_back({table->energy[k], -table->virial[k] / static_cast<double>(k + 1)});
        }
        tail_ = table->tail;
        curve_ = {nodes->data(), 1.0 / spacing, static_cast<double>(count - 2)};
        owner_ = std::move(nodes);
    }

    std::shared_ptr<const std::vector<Node>> owner_;  // keeps the curve's nodes alive in every copy of the law
    Curve curve_;
    Tail tail_;
};

}  // namespace dlpoly::pair
