// The pair table of a scene: for every two species which law acts, how far, and with which drag and noise.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "forces/pair_batch.hpp"

namespace dlpoly {

// Evaluates one kind of pair law over a batch; made by make_kernel for a law of the registry.
class PairKernel {
  public:
    PairKernel() = default;
    PairKernel(const PairKernel&) = delete;
    PairKernel& operator=(const PairKernel&) = delete;
    PairKernel(PairKernel&&) = delete;
    PairKernel& operator=(PairKernel&&) = delete;
    virtual ~PairKernel() = default;

    // Adds one pair of species with its parameters; `term` numbers the entries of the pair table.
    // Throws std::invalid_argument naming a bad parameter.
    virtual void add(std::uint32_t term, std::span<const double> parameters, double cutoff, bool force_shift) = 0;
    // Adds a tabulated pair (only the kernel of "tab").
    virtual void add_table(std::uint32_t term, std::span<const double> energy, std::span<const double> virial,
                           double spacing, double cutoff, bool force_shift) = 0;
    // Writes energy and conservative factor of every pair of the batch (0 beyond the law's own cutoff), up to whole
    // lanes.
    virtual void evaluate(const PairBatch& batch, BatchResult& result) const = 0;
    // Energy and −dU/dr at one distance, for characteristic magnitudes and messages.
    [[nodiscard]] virtual std::pair<double, double> at(std::uint32_t term, double distance) const = 0;
};

// Writes ∇²U of each pair of a batch with respect to one of its beads, U'' + 2U'/r, from the law's forces at distances
// close to the pair's; 0 at contact, where a direction is lacking, and beyond the law's cutoff.
void pair_curvature(const PairKernel& kernel, const PairBatch& batch, double* curvature);

// A kernel for the law with this key. Throws std::invalid_argument for an unknown key.
std::unique_ptr<PairKernel> make_kernel(const std::string& key, std::size_t terms);

// Drag and noise between two species; σ is for the present k_B T and is divided by √Δt by the pair loop.
struct PairDrag {
    double drag = 0.0;    // γ, Da/ps
    double noise = 0.0;   // σ
    double cutoff = 0.0;  // Å
};

class PairTable {
  public:
    explicit PairTable(std::int32_t species);

    // Declares what acts between species a and b; an empty key means no conservative law.
    void set_law(std::int32_t a, std::int32_t b, const std::string& key, std::span<const double> parameters,
                 double cutoff, bool force_shift);
    void set_table(std::int32_t a, std::int32_t b, std::span<const double> energy, std::span<const double> virial,
                   double spacing, double cutoff, bool force_shift);
    void set_drag(std::int32_t a, std::int32_t b, const PairDrag& drag);

    [[nodiscard]] std::int32_t species() const noexcept { return species_; }
    [[nodiscard]] std::uint32_t term(std::int32_t a, std::int32_t b) const noexcept {
        return static_cast<std::uint32_t>(a * species_ + b);
    }
    [[nodiscard]] bool has_drag() const noexcept { return has_drag_; }
    [[nodiscard]] double range() const noexcept { return range_; }  // the largest cutoff of all pairs

    // By term: squared reach of the pair (law or drag, whichever is longer; 0: the pair does nothing) and its drag.
    [[nodiscard]] const std::vector<double>& reach_squared() const noexcept { return reach_squared_; }
    [[nodiscard]] const std::vector<PairDrag>& drags() const noexcept { return drags_; }

    // The soft repulsion of a pair, zeros when it has none.
    struct SoftLaw {
        double repulsion = 0.0;
        double cutoff = 0.0;
    };
    [[nodiscard]] SoftLaw soft_law(std::uint32_t term) const noexcept { return soft_laws_[term]; }
    [[nodiscard]] const std::vector<SoftLaw>& soft_laws() const noexcept { return soft_laws_; }
    // Whether every pair has the law dpd or none, over its own range, and a drag of the same range or none.
    [[nodiscard]] bool is_soft() const noexcept;

    // The kernel of an entry; nullptr for pairs that have no conservative law.
    [[nodiscard]] const PairKernel* kernel(std::uint32_t term) const noexcept {
        return kernel_of_[term] < kernels_.size() ? kernels_[kernel_of_[term]].get() : nullptr;
    }
    [[nodiscard]] std::size_t terms() const noexcept { return terms_; }

    // The largest force that beads at thermal energy meet: the pair forces where U rises 50 k_B T above its value at
    // the cutoff (or at contact, for soft laws). It only chooses the grid of the exact sums.
    [[nodiscard]] double characteristic_force(double thermal_energy) const;

  private:
    std::uint32_t kernel_index(const std::string& key);
    void set_reach(std::int32_t a, std::int32_t b, double cutoff);

    std::int32_t species_;
    std::size_t terms_;
    bool has_drag_ = false;
    double range_ = 0.0;
    std::vector<std::string> keys_;
    std::vector<std::unique_ptr<PairKernel>> kernels_;
    std::vector<double> law_cutoff_;
    std::vector<double> reach_squared_;
    std::vector<std::uint32_t> kernel_of_;
    std::vector<PairDrag> drags_;
    std::vector<SoftLaw> soft_laws_;
    bool only_soft_ = true;
};

}  // namespace dlpoly
