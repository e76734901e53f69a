// The templated law loop: one instantiation for every law of the registry, which it knows only as a type.
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "forces/pair_table.hpp"
#include "pair/registry.hpp"
#include "pair/shift.hpp"

namespace dlpoly {

namespace {

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
        for (std::size_t k = 0; k < batch.size; ++k) {
            const Slot& slot = *slots_[batch.term[k]];
            const double distance_squared = batch.distance_squared[k];
            pair::PairValue value = slot.law(distance_squared);
            if (slot.shifted) {
                value = pair::shifted(value, slot.shift, distance_squared);
            }
            const bool inside = distance_squared < slot.cutoff_squared;
            result.energy[k] = inside ? value.energy : 0.0;
            result.conservative[k] = inside ? value.force_over_r : 0.0;
        }
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
};

}  // namespace

std::unique_ptr<PairKernel> make_kernel(const std::string& key, std::size_t terms) {
    std::unique_ptr<PairKernel> kernel;
    pair::visit(key, [&]<class Law>() { kernel = std::make_unique<LawKernel<Law>>(terms); });
    return kernel;
}

}  // namespace dlpoly
