// The fast path: soft fluids with or without pair drag and noise in orthorhombic boxes.
//
// It takes over positions, momenta and impulses from the state at the start of a chunk of steps and gives them back at
// its end; both conversions are exact, so that a run does not depend on how it is cut into chunks.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bonded/bonded_forces.hpp"
#include "charge/charge_forces.hpp"
#include "core/state.hpp"
#include "fast/arguments.hpp"
#include "forces/pair_forces.hpp"
#include "integrate/step_settings.hpp"

namespace dlpoly::fast {

// Why a scene cannot take the fast path, in words; empty when it can.
std::string refusal(const Box& box, const Particles& particles, const PairTable& table, const StepSettings& settings,
                    bool has_external_fields);

// The passes of the best instruction set of this processor, or of the one that the environment variable PYDLPOLY_SIMD
// names (plain, avx2, avx512). Throws std::invalid_argument when that is unknown or not supported here.
const Passes& chosen_passes();

// A fluid on the fast path; made by make_fluid for the precision asked for.
class Fluid {
  public:
    Fluid() = default;
    Fluid(const Fluid&) = delete;
    Fluid& operator=(const Fluid&) = delete;
    Fluid(Fluid&&) = delete;
    Fluid& operator=(Fluid&&) = delete;
    virtual ~Fluid() = default;

    // Bonded terms to be added in every step; their totals are written in observed ones. Both must outlive the fluid.
    virtual void set_bonded(BondedForces& terms, BondedTotals& totals, std::vector<std::int32_t> species) = 0;

    // Electrostatics to be added in every step, and where the totals of observed ones go. Both must outlive the fluid.
    virtual void set_charges(ChargeForces& charges, ChargeTotals& totals) = 0;

    // Computes and observes the forces of the present positions and velocities.
    virtual void start(State& state, const StepSettings& settings, PairTotals& totals) = 0;

    // Takes steps; the last one is observed. Positions, velocities, forces, images, step and time of the state are
    // those after it. Throws RunFailure when momenta leave the range of their fixed-point numbers.
    virtual void run(State& state, const StepSettings& settings, std::uint64_t steps, PairTotals& totals) = 0;
};

// mixed: pair arithmetic in single precision; else in double.
std::unique_ptr<Fluid> make_fluid(const State& state, const PairTable& table, const StepSettings& settings,
                                  const Passes& passes, bool mixed, double cell_width = 0.0);

}  // namespace dlpoly::fast
