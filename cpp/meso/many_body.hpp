// Many-body DPD: an energy Σ ψ(ρ̄_i) of local densities ρ̄_i = Σ_j W(r_ij), with ψ = C ρ̄^m/m and
// W = W(0) (1 − r/r_d)^n (Pagonabarraga and Frenkel 2001; Warren 2003; Vanya and Elliott 2020), beside the pair law
// mdpd. Its forces are pairwise, −(ψ'_i + ψ'_j) W'(r). Densities are exact sums of integers, the same bits for any
// number of threads.
//
// With Lucy's kernel, as LAMMPS has it, the force is push (ρ̄_i + ρ̄_j)(1 − r/r_d), which no energy belongs to.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "forces/pair_forces.hpp"
#include "forces/pair_modifier.hpp"
#include "meso/many_body_loops.hpp"

namespace dlpoly {

enum class DensityKernel : std::uint8_t { power, lucy };

// What two species are to each other's local densities.
struct DensityPair {
    double height = 0.0;    // W(0)
    double exponent = 2.0;  // n
    double range = 0.0;     // r_d; 0: nothing
    double push = 0.0;      // force at contact over φ_i + φ_j, φ = ψ' or, with Lucy's kernel, ρ̄
};

struct ManyBodySettings {
    DensityKernel kernel = DensityKernel::power;
    double strength = 0.0;           // C; not used with Lucy's kernel
    std::vector<double> powers;      // m of every species
    std::vector<DensityPair> pairs;  // by entry of the pair table
};

class ManyBody final : public PairModifier {
  public:
    // Throws std::invalid_argument for numbers without a meaning.
    explicit ManyBody(ManyBodySettings settings);

    void prepare(PairForces& pairs, const Box& box, const Particles& particles, int threads) override;
    void change_conservative(const PairBatch& batch, BatchResult& result) const override;
    [[nodiscard]] double energy() const override;
    void change_curvature(const PairBatch& batch, double* curvature) const override;
    [[nodiscard]] double curvature(PairForces& pairs, const Box& box, const Particles& particles) override;
    [[nodiscard]] double characteristic_force() const override;

    // Of every bead, by id, at the last prepared evaluation; empty before the first.
    [[nodiscard]] std::vector<double> local_densities() const;

  private:
    // ψ and its derivatives.
    [[nodiscard]] double energy_at(double density, std::int32_t species) const;
    [[nodiscard]] double slope_at(double density, std::int32_t species) const;
    [[nodiscard]] double second_slope_at(double density, std::int32_t species) const;
    void add_frozen(const Box& box, const Particles& particles);
    void find_frozen_densities(const Box& box, const Particles& particles);

    ManyBodySettings settings_;
    const ManyBodyLoops* loops_;
    int exponent_ = 0;  // of the grid of densities
    int threads_ = 1;
    std::vector<std::uint32_t> order_;   // ids of what follows, in sorted order
    std::vector<std::int32_t> species_;  // likewise
    std::vector<std::int64_t> sums_;
    std::vector<double> densities_;
    std::vector<double> responses_;  // φ

    // Frozen beads are neighbours of each other that the pair list leaves out.
    std::vector<std::uint32_t> frozen_;  // ids
    Array3N frozen_positions_;
    Matrix3 frozen_cell_ = Matrix3::Zero();
    std::vector<std::int64_t> frozen_sums_;  // by place in frozen_
    double frozen_energy_ = 0.0;             // of their densities alone, in no total
};

}  // namespace dlpoly
