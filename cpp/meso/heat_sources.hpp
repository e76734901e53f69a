// Sources and sinks of heat: temperature per time for the beads that are, at the end of a step, in a region of the cell
// or of a species. What they bring is counted in State::heat_supplied.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "meso/bead_process.hpp"
#include "meso/heat_pairs.hpp"

namespace dlpoly {

// Where a source acts: positions are wrapped ones, from the cell's centre.
struct HeatBox {
    std::array<double, 3> low, high;
};
struct HeatSphere {
    Vector3 centre;
    double radius;
};
struct HeatSpecies {
    std::int32_t species;
};

struct HeatSource {
    std::variant<HeatBox, HeatSphere, HeatSpecies> where;
    double rate;  // of k_B T, per ps; below 0 for sinks
};

class HeatSources final : public BeadProcess {
  public:
    HeatSources(std::vector<HeatSource> sources, std::shared_ptr<const HeatPairs> pairs)
        : sources_(std::move(sources)), pairs_(std::move(pairs)) {}

    // A sink takes at most half of a bead's heat in one step.
    void advance(State& state, Forces& forces, const StepSettings& settings) override;

  private:
    std::vector<HeatSource> sources_;
    std::shared_ptr<const HeatPairs> pairs_;
};

}  // namespace dlpoly
