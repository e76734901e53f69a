// Bonded law tab of bonds, angles, dihedrals and inversions: a cubic Hermite curve through the values of a table.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bonded/law.hpp"

namespace dlpoly::bonded {

// The curve has U and its slope at the nodes, and the force is exactly its derivative, so that energy is conserved
// whatever the spacing. Between nodes h apart U is wrong by at most h⁴/384 times the fourth derivative. Beyond its ends
// U is not finite.
template <Kind of>
class Tabulated {
    struct Node {
        double energy;
        double slope;  // times the spacing
    };

  public:
    static constexpr LawInfo info{.kind = of,
                                  .key = "tab",
                                  .restraint_key = "-tab",
                                  .description = "tabulated, U and its slope from a file",
                                  .parameter_names = {},
                                  .energy_mask = 0,
                                  .limit = "it lies outside its table",
                                  .table = true};

    // The numbers are the first node's coordinate, the spacing, all energies and then all slopes.
    explicit Tabulated(std::span<const double> numbers) {
        const std::string law = std::string(name(of)) + " law tab: ";
        if (numbers.size() < 6 || numbers.size() % 2 != 0) {
            throw std::invalid_argument(law + "a table has a start, a spacing and at least two nodes with U and slope");
        }
        if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }) ||
            !(numbers[1] > 0.0)) {
            throw std::invalid_argument(law + "the numbers of a table must be finite and its spacing positive");
        }
        const std::size_t count = numbers.size() / 2 - 1;
        auto nodes = std::make_shared<std::vector<Node>>(count);
        for (std::size_t k = 0; k < count; ++k) {
            (*nodes)[k] = {numbers[2 + k], numbers[2 + count + k] * numbers[1]};
        }
        start_ = numbers[0];
        inverse_spacing_ = 1.0 / numbers[1];
        nodes_ = std::move(nodes);
    }

    auto operator()(double at, double /*first*/ = 0.0, double /*second*/ = 0.0) const noexcept {
        const Value value = curve(at);
        if constexpr (of == Kind::angle) {
            return AngleValue{value.energy, value.slope};
        } else {
            return value;
        }
    }

  private:
    Value curve(double at) const noexcept {
        constexpr double infinite = std::numeric_limits<double>::infinity();
        // Ends are written with few digits, and an angle of 180 degrees may be rounded up.
        constexpr double margin = 1e-6;
        const double position = (at - start_) * inverse_spacing_;
        const auto intervals = static_cast<double>(nodes_->size() - 1);
        if (!(position >= -margin && position <= intervals + margin)) {
            return {infinite, infinite};
        }
        const double left = std::clamp(std::floor(position), 0.0, intervals - 1.0);
        const double t = position - left;
        const Node& a = (*nodes_)[static_cast<std::size_t>(left)];
        const Node& b = (*nodes_)[static_cast<std::size_t>(left) + 1];
        const double rise = b.energy - a.energy;
        const double quadratic = 3.0 * rise - 2.0 * a.slope - b.slope;
        const double cubic = a.slope + b.slope - 2.0 * rise;
        return {a.energy + t * (a.slope + t * (quadratic + t * cubic)),
                (a.slope + t * (2.0 * quadratic + 3.0 * t * cubic)) * inverse_spacing_};
    }

    std::shared_ptr<const std::vector<Node>> nodes_;  // shared by copies of the law
    double start_ = 0.0;
    double inverse_spacing_ = 0.0;
};

using TabulatedBond = Tabulated<Kind::bond>;
using TabulatedAngle = Tabulated<Kind::angle>;
using TabulatedDihedral = Tabulated<Kind::dihedral>;
using TabulatedInversion = Tabulated<Kind::inversion>;

}  // namespace dlpoly::bonded
