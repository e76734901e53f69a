// Dissolved species between beads: Fickian and random fluxes of transport DPD (Li, Yazdani, Tartakovsky and
// Karniadakis, J. Chem. Phys. 143, 014101 (2015)), pair after pair, each pair's difference by the exact solution of its
// equation.
//
//   dC_i = −κ w² (C_i − C_j) dt + ε w f(C_i + C_j) dW,  dC_j = −dC_i,  w² = (1 − r/r_c)^s,  f(S) = √S or S.
//
// S does not change, so that the difference is an Ornstein–Uhlenbeck process: it shrinks by exp(−2κw²Δt) and gets a
// normal number of variance ε² f(S)² (1 − exp(−4κw²Δt))/κ. No amount falls below 0 for any Δt: the first step is a mean
// of both beads, and the random part is cut, on both sides alike so that its mean stays 0, to the smaller of the two.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/state.hpp"
#include "forces/exclusions.hpp"
#include "forces/pair_table.hpp"
#include "integrate/step_settings.hpp"
#include "sweep/pair_rows.hpp"

namespace dlpoly {

enum class FluxNoise : std::uint8_t {
    none,
    root,    // f(S) = √S: what molecules that hop one by one make
    linear,  // f(S) = S, and normal numbers cut to ±5: LAMMPS
};

// What one dissolved species does between beads of two species.
struct SpeciesFlux {
    double rate = 0.0;  // κ, 1/ps
    double range = 0.0;
    double exponent = 2.0;  // s of w²
    double noise = 0.0;     // ε
};

class SpeciesExchange {
  public:
    SpeciesExchange(std::int32_t bead_species, std::int32_t dissolved);

    void set_flux(std::int32_t a, std::int32_t b, std::int32_t dissolved, const SpeciesFlux& flux);
    // Beads of a species keep what they have of a dissolved species, whatever flows.
    void set_held(std::int32_t bead_species, std::int32_t dissolved);
    void set_noise(FluxNoise noise) noexcept { noise_ = noise; }

    // Lets `duration` pass between all pairs. Adds what flowed out of held beads to `outflow`, by dissolved species.
    void sweep(State& state, const PairTable& table, const StepSettings& settings, double duration, bool backward,
               std::vector<double>& outflow);

    [[nodiscard]] bool is_held(std::int32_t bead_species, std::int32_t dissolved) const {
        return held_[place(bead_species, dissolved)] != 0;
    }

  private:
    using Row = PairRows::Row;
    enum class Kind : std::uint8_t { free, first_held, second_held, both_held };
    // What a thread makes of the pairs of its row, by dissolved species and pair.
    struct Maps {
        std::vector<double> distance, lost, noise;
    };
    struct Draws {
        double duration;
        std::uint64_t seed, step;
        bool strong;  // Philox4x32-10 for every pair
    };

    [[nodiscard]] std::size_t place(std::int32_t row, std::int32_t dissolved) const {
        return static_cast<std::size_t>(row) * count_ + static_cast<std::size_t>(dissolved);
    }
    void prepare(const PairTable& table);
    void make_maps(const Row& row, Maps& maps, const Draws& draws) const;
    template <bool quadratic, bool gentle>
    void make_losses(const Row& row, Maps& maps, double duration) const;
    void make_noise(const Row& row, Maps& maps, const Draws& draws) const;
    [[nodiscard]] double strong_normal(const Row& row, std::size_t k, std::size_t s, const Draws& draws) const;
    template <FluxNoise noise, bool holds>
    void use_maps(const Row& row, const Maps& maps, bool backward, double* outflow);
    void use_row(const Row& row, const Maps& maps, bool backward, double* outflow);

    std::size_t count_;  // of dissolved species
    std::size_t bead_species_;
    FluxNoise noise_ = FluxNoise::none;
    std::vector<SpeciesFlux> flux_;   // by term of the pair table and dissolved species
    std::vector<Kind> kind_;          // likewise
    std::vector<std::uint8_t> held_;  // by bead species and dissolved species
    bool any_held_ = false;
    bool quadratic_ = true;
    double largest_rate_ = 0.0;
    const Exclusions none_;
    std::optional<PairRows> rows_;
    std::vector<double> amount_;  // sorted
    std::vector<std::uint32_t> word_;
    std::vector<Maps> maps_;  // one a thread
};

}  // namespace dlpoly
