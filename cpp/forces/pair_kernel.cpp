// The templated law loop: one instantiation for every law of the registry, which it knows only as a type, and every
// instruction set.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/compiler.hpp"
#include "forces/pair_phases.hpp"
#include "forces/pair_table.hpp"
#include "pair/registry.hpp"
#include "pair/shift.hpp"

namespace dlpoly {

namespace {

// The distances of a batch and what a law makes of them. `count` is a multiple of batch_lanes.
struct LawLoop {
    const double* distance_squared;
    double* energy;
    double* conservative;
    std::size_t count;
    double cutoff_squared;
    bool some_outside;  // pairs may be farther apart than the law's own cutoff
    bool shifted;
    pair::Shift shift;
};

// Always part of its caller, so that it is compiled for the caller's instruction set.
template <class Law>
DLPOLY_ALWAYS_INLINE void run_law(const Law& law, const LawLoop& loop) {
    const double* DLPOLY_RESTRICT squared = loop.distance_squared;
    double* DLPOLY_RESTRICT energy = loop.energy;
    double* DLPOLY_RESTRICT conservative = loop.conservative;
    const std::size_t count = loop.count / batch_lanes * batch_lanes;
    // A copy, so that the compiler knows that no store changes the law's numbers.
    const auto value_at = pair::evaluator(law);
    if (loop.shifted) {
        const pair::Shift shift = loop.shift;
        for (std::size_t k = 0; k < count; ++k) {
            const pair::PairValue value = pair::shifted(value_at(squared[k]), shift, squared[k]);
            energy[k] = value.energy;
            conservative[k] = value.force_over_r;
        }
    } else {
        for (std::size_t k = 0; k < count; ++k) {
            const pair::PairValue value = value_at(squared[k]);
            energy[k] = value.energy;
            conservative[k] = value.force_over_r;
        }
    }
    if (loop.some_outside) {
        const double cutoff_squared = loop.cutoff_squared;
        for (std::size_t k = 0; k < count; ++k) {
            const bool inside = squared[k] < cutoff_squared;
            energy[k] = inside ? energy[k] : 0.0;
            conservative[k] = inside ? conservative[k] : 0.0;
        }
    }
}

template <class Law>
void run_plain(const Law& law, const LawLoop& loop) {
    run_law(law, loop);
}

#ifdef DLPOLY_LAW_VECTORS
// `flatten` draws everything the law calls into the loop, so that nothing compiled for these sets can be met elsewhere.
template <class Law>
DLPOLY_FOR_AVX2 void run_avx2(const Law& law, const LawLoop& loop) {
    run_law(law, loop);
}

template <class Law>
DLPOLY_FOR_AVX512 void run_avx512(const Law& law, const LawLoop& loop) {
    run_law(law, loop);
}
#endif

// The loop for the same instruction set as the other phases.
template <class Law>
auto choose_loop() -> void (*)(const Law&, const LawLoop&) {
#ifdef DLPOLY_LAW_VECTORS
    using Loop = void (*)(const Law&, const LawLoop&);
    return chosen_version<Loop>(&run_plain<Law>, &run_avx2<Law>, &run_avx512<Law>);
#else
    return &run_plain<Law>;
#endif
}

template <class Law>
class LawKernel final : public PairKernel {
  public:
    explicit LawKernel(std::size_t terms) : slots_(terms) {}

    void add(std::uint32_t term, std::span<const double> parameters, double cutoff, bool force_shift) override {
        if constexpr (std::is_constructible_v<Law, std::span<const double>, double>) {
            place(term, Law(parameters, cutoff), cutoff, force_shift);
        } else {
            throw std::invalid_argument("a tabulated pair law needs its table");
        }
    }

    void add_table(std::uint32_t term, std::span<const double> energy, std::span<const double> virial, double spacing,
                   double cutoff, bool force_shift) override {
        if constexpr (std::is_constructible_v<Law, std::span<const double>, double>) {
            throw std::invalid_argument("only the law 'tab' takes a table");
        } else {
            auto table = std::make_shared<pair::Table>();
            table->spacing = spacing;
            table->energy.assign(energy.begin(), energy.end());
            table->virial.assign(virial.begin(), virial.end());
            place(term, Law::make(table, cutoff), cutoff, force_shift);
        }
    }

    void evaluate(const PairBatch& batch, BatchResult& result) const override {
        const Slot& slot = *slots_[batch.term];
        const LawLoop loop{batch.distance_squared.values,
                           result.energy.values,
                           result.conservative.values,
                           (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes,
                           slot.cutoff_squared,
                           slot.cutoff_squared < batch.reach_squared,
                           slot.shifted,
                           slot.shift};
        run_(slot.law, loop);
    }

    [[nodiscard]] std::pair<double, double> at(std::uint32_t term, double distance) const override {
        const pair::PairValue value = slots_[term]->law(distance * distance);
        return {value.energy, value.force_over_r * distance};
    }

  private:
    struct Slot {
        Law law;
        double cutoff;
        double cutoff_squared;
        bool shifted;
        pair::Shift shift;
    };

    void place(std::uint32_t term, Law law, double cutoff, bool force_shift) {
        const bool shifted = force_shift && Law::info.shiftable;
        const pair::Shift shift = shifted ? pair::shift_of(law, cutoff) : pair::Shift{};
        slots_[term].emplace(Slot{std::move(law), cutoff, cutoff * cutoff, shifted, shift});
    }

    std::vector<std::optional<Slot>> slots_;
    void (*run_)(const Law&, const LawLoop&) = choose_loop<Law>();
};

}  // namespace

void pair_curvature(const PairKernel& kernel, const PairBatch& batch, double* curvature) {
    constexpr double shift = 1e-5;
    const std::size_t whole = (batch.size + batch_lanes - 1) / batch_lanes * batch_lanes;
    PairBatch moved;
    moved.size = batch.size;
    moved.term = batch.term;
    moved.reach_squared = std::numeric_limits<double>::infinity();  // the law checks its own cutoff
    std::array<BatchResult, 3> at;                                  // the distance, and a little more and less
    const std::array<double, 3> scale{1.0, (1.0 + shift) * (1.0 + shift), (1.0 - shift) * (1.0 - shift)};
    for (std::size_t n = 0; n < 3; ++n) {
        for (std::size_t k = 0; k < whole; ++k) {
            moved.distance_squared.values[k] = batch.distance_squared.values[k] * scale[n];
        }
        kernel.evaluate(moved, at[n]);
    }
    for (std::size_t k = 0; k < batch.size; ++k) {
        const double here = at[0].conservative.values[k];
        const double farther = at[1].conservative.values[k];
        const double nearer = at[2].conservative.values[k];
        // d(fr)/dr with the force f·r. Where the law ends between the two distances, its inner side counts.
        const bool ends = farther == 0.0 && nearer != 0.0;
        const double change = ends ? (here - nearer * (1.0 - shift)) / shift
                                   : (farther * (1.0 + shift) - nearer * (1.0 - shift)) / (2.0 * shift);
        curvature[k] = batch.distance_squared.values[k] > 0.0 ? -change - 2.0 * here : 0.0;
    }
}

std::unique_ptr<PairKernel> make_kernel(const std::string& key, std::size_t terms) {
    std::unique_ptr<PairKernel> kernel;
    pair::visit(key, [&]<class Law>() { kernel = std::make_unique<LawKernel<Law>>(terms); });
    return kernel;
}

}  // namespace dlpoly
