// The terms of one bonded law, behind one interface whatever the law.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "bonded/bonded_worker.hpp"
#include "bonded/geometry.hpp"
#include "bonded/law.hpp"
#include "bonded/magnitude.hpp"

namespace dlpoly::bonded {

// Where the beads are: one position a bead by id, in any periodic image; anchors of tethers likewise.
struct Places {
    const MinimumImage& image;
    const double* positions;  // 3 a bead
    const double* anchors;    // 3 a bead; used by tethers alone

    [[nodiscard]] Vector3 position(std::uint32_t bead) const noexcept { return at(positions, bead); }
    [[nodiscard]] Vector3 anchor(std::uint32_t bead) const noexcept { return at(anchors, bead); }

  private:
    static Vector3 at(const double* array, std::uint32_t bead) noexcept {
        const double* p = array + 3 * std::size_t{bead};
        return {p[0], p[1], p[2]};
    }
};

// Second derivatives of the energy, added exactly: rounded once to a grid.
struct CurvatureSum {
    double scale = 1.0;
    WideSum sum;
    bool lost = false;  // a term was not finite or beyond the grid

    void add(double value) noexcept {
        const double scaled = value * scale;
        if (std::abs(scaled) < largest_wide_term) {
            sum.add(std::llrint(scaled));
        } else {
            lost = true;
        }
    }
};

class TermList {
  public:
    TermList() = default;
    TermList(const TermList&) = delete;
    TermList& operator=(const TermList&) = delete;
    TermList(TermList&&) = delete;
    TermList& operator=(TermList&&) = delete;
    virtual ~TermList() = default;

    [[nodiscard]] virtual const LawInfo& info() const noexcept = 0;
    [[nodiscard]] virtual std::size_t size() const noexcept = 0;

    // A set of parameters for the terms that are added after it. Returns what its terms will be like.
    virtual Magnitude set_parameters(std::span<const double> parameters, double thermal_energy) = 0;
    // One term between as many beads as the kind has.
    virtual void add(const std::uint32_t* beads) = 0;

    // Orders the terms so that part p, the terms whose beads all lie in [bounds[p], bounds[p + 1]), are consecutive,
    // and the terms that cross a bound come last as one more part.
    virtual void partition(std::span<const std::uint32_t> bounds) = 0;

    // Adds Σ ∂²U/∂x² over the coordinates of the mobile beads of terms [first, last), from differences of their forces;
    // not a number when a term cannot be computed. force_scale is the grid that the terms' forces fit, as in Request.
    virtual void add_curvature(std::size_t first, std::size_t last, const Places& places,
                               std::span<const std::uint8_t> frozen, double force_scale, CurvatureSum& sum) const = 0;

    // Adds the terms of one part.
    virtual void evaluate(std::size_t part, const Places& places, Worker& worker) const = 0;
};

// Throws std::invalid_argument for an unknown key.
std::unique_ptr<TermList> make_term_list(Kind kind, std::string_view key);

}  // namespace dlpoly::bonded
