// A sweep: every pair within the range of its drag, one after the other, gets a new relative velocity along its axis
// from the velocities that the pairs before it left behind.
//
// The order of the pairs is part of the result; it follows from the positions alone (see pair_rows.hpp), so results are
// the same bits for any number of threads, chunks and restarts.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/box.hpp"
#include "core/particles.hpp"
#include "core/random.hpp"
#include "forces/exclusions.hpp"
#include "forces/pair_table.hpp"
#include "meso/heat_pairs.hpp"
#include "sweep/pair_map.hpp"
#include "sweep/pair_rows.hpp"

namespace dlpoly {

// What is the same for all pairs of one sweep.
struct SweepSettings {
    double duration = 0.0;         // h, ps
    double thermal_energy = 0.0;   // k_B T
    double weight_exponent = 2.0;  // s of w^D
    double transverse_drag = 0.0;  // γ⊥ as a multiple of the pair's γ, acting across the axis
    double rate = 0.0;             // thermostats that choose pairs: Γ, 1/ps, in place of ½γ/μ; 0 = none
    double shear_rate = 0.0;       // of the cell, 1/ps: velocities are taken relative to the flow
    std::uint64_t seed = 0;
    std::uint64_t step = 0;
    Stream stream = Stream::sweep_words;
    bool strong_noise = false;  // Philox4x32-10 for every pair instead of the mix of two beads' words
    bool backward = false;      // the pairs in opposite order
    bool observe = false;       // also the virial of the impulses
    // Beads carry heat: pairs have their own k_B T, and the kinetic energy they lose becomes heat.
    const HeatPairs* heat = nullptr;
};

class PairSweep {
  public:
    PairSweep(const PairTable& table, const Exclusions& exclusions);

    // Applies the map to all pairs. Velocities change; positions do not. Maps: see the headers in this folder.
    template <class Map>
    void apply(const Box& box, Particles& particles, const Map& map, const SweepSettings& settings);

    // Σ Δp_a r_b/h over the pairs of the last sweep that observed.
    [[nodiscard]] const Matrix3& virial() const noexcept { return virial_; }

    // What the last sweep gave to beads whose internal temperature is held.
    [[nodiscard]] double heat_of_held() const noexcept { return heat_of_held_; }

    // Sums over all pairs at the present velocities.
    struct PairTemperature {
        double excess = 0.0;  // Σ w^D (u² − k_B T/μ)
        double energy = 0.0;  // Σ w μ u²
        double weight = 0.0;  // Σ w
        std::int64_t pairs = 0;
    };
    [[nodiscard]] PairTemperature measure(const Box& box, const Particles& particles, const SweepSettings& settings);

  private:
    using Row = PairRows::Row;
    // What a thread makes of the pairs of its row.
    struct Maps {
        std::vector<sweep::LinearMap> map;
        std::vector<double> across;  // three numbers a pair: noise across the axis
    };
    struct Velocity {
        double x, y, z, inverse_mass;
    };
    // Of a bead that carries heat: its temperature before the sweep, by which coefficients go, and what it gained
    // since.
    struct Heat {
        double temperature, capacity, inverse_capacity, gained;
        bool held;

        // Whether so much more would leave it with nothing; not where it is no number, which is found afterwards.
        [[nodiscard]] bool lacks(double more) const noexcept {
            return !held && temperature * capacity + (gained + more) <= 0.0;
        }
    };

    void sort(const Box& box, const Particles& particles, const SweepSettings& settings, int threads);
    [[nodiscard]] sweep::PairDraw draw_of(const Row& row, std::size_t k, const SweepSettings& settings, bool uniform,
                                          double* across) const;
    void gather_heat(const Particles& particles, const HeatPairs& pairs, int threads);
    void spread_heat(Particles& particles);
    template <bool heated, class Map>
    void make_maps(const Row& row, Maps& maps, const Map& map, const SweepSettings& settings) const;
    template <bool heated>
    void use_maps(const Row& row, const Maps& maps, const SweepSettings& settings, std::array<double, 6>* virial);
    template <bool sheared, bool heated>
    void use_all(const Row& row, const Maps& maps, const SweepSettings& settings, std::array<double, 6>* virial);
    template <bool sheared, bool heated>
    void use_pair(const Row& row, const Maps& maps, std::size_t k, const SweepSettings& settings,
                  std::array<double, 6>* virial);
    template <bool heated>
    [[nodiscard]] sweep::PairSituation situation(const Row& row, std::size_t k, const SweepSettings& settings) const;

    const PairTable& table_;
    PairRows rows_;
    std::vector<Velocity> velocity_;  // sorted
    std::vector<std::uint32_t> word_;
    std::vector<Heat> heat_;  // sorted; empty where beads carry none
    double heat_of_held_ = 0.0;
    std::vector<Maps> maps_;  // one a thread
    Matrix3 virial_ = Matrix3::Zero();
};

}  // namespace dlpoly
