// The stress in layers (see stress_profile.hpp).
#include "observe/stress_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>

#include "core/exact_sum.hpp"
#include "core/failure.hpp"
#include "core/threads.hpp"

namespace dlpoly {

namespace {

constexpr std::size_t components = 6;
constexpr double largest_layer_term = 0x1p61;  // WideSum takes terms of 64 bits

using Tensor = std::array<double, components>;

// F_a r_b; off the diagonal the mean of both.
Tensor tensor_of(const Vector3& force, const Vector3& arm) noexcept {
    return {force[0] * arm[0],
            force[1] * arm[1],
            force[2] * arm[2],
            0.5 * (force[0] * arm[1] + force[1] * arm[0]),
            0.5 * (force[0] * arm[2] + force[2] * arm[0]),
            0.5 * (force[1] * arm[2] + force[2] * arm[1])};
}

// Heights in the cell in units of layers, 0 at its lower face.
class Layers {
  public:
    Layers(const Box& box, int axis, std::int32_t count) : axis_(axis), count_(count) {
        if (axis < 0 || axis > 2 || count < 1) {
            throw std::invalid_argument("a stress profile needs an axis 0, 1 or 2 and at least one layer");
        }
        for (Eigen::Index k = 0; k < 3; ++k) {
            if (k != axis && (box.cell()(axis, k) != 0.0 || box.cell()(k, axis) != 0.0)) {
                throw std::invalid_argument(
                    "a stress profile needs a cell vector along its axis, perpendicular to the other two");
            }
        }
        if (!box.periodic()[static_cast<std::size_t>(axis)]) {
            throw std::invalid_argument("a stress profile needs a cell that is periodic along its axis");
        }
        per_length_ = count / box.cell()(axis, axis);
    }

    [[nodiscard]] double rise(const Vector3& arm) const noexcept { return arm[axis_] * per_length_; }
    [[nodiscard]] double height(const Particles& particles, std::uint32_t bead) const noexcept {
        return particles.position(static_cast<Eigen::Index>(bead), axis_) * per_length_ + 0.5 * count_;
    }
    [[nodiscard]] std::size_t layer(double height) const noexcept {
        const double wrapped = std::floor(height) - count_ * std::floor(std::floor(height) / count_);
        return static_cast<std::size_t>(wrapped);
    }
    [[nodiscard]] std::size_t count() const noexcept { return static_cast<std::size_t>(count_); }

  private:
    Eigen::Index axis_;
    std::int32_t count_;
    double per_length_ = 0.0;
};

// One thread's exact sums.
class LayerSums {
  public:
    LayerSums(const Layers& layers, double scale)
        : layers_(&layers), scale_(scale), sums_(layers.count() * components) {}

    void add(std::size_t layer, const Tensor& tensor, double share) noexcept {
        for (std::size_t k = 0; k < components; ++k) {
            const double term = tensor[k] * share * scale_;
            largest_ = std::max(largest_, std::abs(term));
            lost_ = lost_ || !std::isfinite(term);
            if (std::abs(term) < largest_layer_term) {
                sums_[layer * components + k].add(std::llrint(term));
            }
        }
    }

    // A force that acts along the line from height − rise to `height`, shared out by length.
    void add_line(const Tensor& tensor, double height, double rise) noexcept {
        const double low = std::min(height, height - rise);
        const double high = std::max(height, height - rise);
        const double first = std::floor(low);
        const double last = std::floor(high);
        if (first == last || !(high > low)) {
            add(layers_->layer(first), tensor, 1.0);
            return;
        }
        const double per_length = 1.0 / (high - low);
        add(layers_->layer(first), tensor, (first + 1.0 - low) * per_length);
        for (double floor = first + 1.0; floor < last; floor += 1.0) {
            add(layers_->layer(floor), tensor, per_length);
        }
        add(layers_->layer(last), tensor, (high - last) * per_length);
    }

    void add(const LayerSums& other) noexcept {
        for (std::size_t k = 0; k < sums_.size(); ++k) {
            sums_[k].add(other.sums_[k]);
        }
        largest_ = std::max(largest_, other.largest_);
        lost_ = lost_ || other.lost_;
    }

    [[nodiscard]] double largest() const noexcept { return largest_; }
    [[nodiscard]] bool lost() const noexcept { return lost_; }
    [[nodiscard]] std::vector<double> values(int exponent) const {
        std::vector<double> values;
        values.reserve(sums_.size());
        for (const WideSum& sum : sums_) {
            values.push_back(sum.value(exponent));
        }
        return values;
    }

  private:
    const Layers* layers_;
    double scale_;
    std::vector<WideSum> sums_;
    double largest_ = 0.0;
    bool lost_ = false;
};

class PairLines final : public PairVisitor {
  public:
    PairLines(const Layers& layers, const Particles& particles, std::span<LayerSums> sums)
        : layers_(layers), particles_(particles), sums_(sums) {}

    void visit(const PairBatch& batch, const double* factors, const std::uint32_t* order, int thread) override {
        LayerSums& sums = sums_[static_cast<std::size_t>(thread)];
        for (std::size_t k = 0; k < batch.size; ++k) {
            const Vector3 arm(batch.dx.values[k], batch.dy.values[k], batch.dz.values[k]);
            sums.add_line(tensor_of(factors[k] * arm, arm), layers_.height(particles_, order[batch.i.values[k]]),
                          layers_.rise(arm));
        }
    }

  private:
    const Layers& layers_;
    const Particles& particles_;
    std::span<LayerSums> sums_;
};

class TermLines final : public bonded::TermVisitor {
  public:
    TermLines(const Layers& layers, const Particles& particles, LayerSums& pairs, LayerSums& terms)
        : layers_(layers), particles_(particles), pairs_(pairs), terms_(terms) {}

    void visit(std::size_t component, std::span<const std::uint32_t> beads, std::span<const Vector3> forces,
               std::span<const Vector3> arms) override {
        LayerSums& sums = component == bonded::scaled_pairs ? pairs_ : terms_;
        const double height = layers_.height(particles_, beads.back());
        if (beads.size() == 1) {
            sums.add_line(tensor_of(forces[0], arms[0]), height, layers_.rise(arms[0]));
            return;
        }
        Vector3 rest = Vector3::Zero();
        for (const Vector3& force : forces) {
            rest -= force;
        }
        const double share = 1.0 / static_cast<double>(beads.size());
        for (std::size_t a = 0; a < arms.size(); ++a) {
            const double top = height + layers_.rise(arms[a]);
            for (std::size_t b = a + 1; b < beads.size(); ++b) {
                const bool last = b == arms.size();
                const Vector3 arm = last ? arms[a] : Vector3(arms[a] - arms[b]);
                const Vector3 force = share * (forces[a] - (last ? rest : forces[b]));
                sums.add_line(tensor_of(force, arm), top, layers_.rise(arm));
            }
        }
    }

  private:
    const Layers& layers_;
    const Particles& particles_;
    LayerSums& pairs_;
    LayerSums& terms_;
};

// Calls `walk` with an exponent of the grid, and again with a coarser one when a term was beyond it. The choice depends
// on the largest term alone, so it is the same for any number of threads.
template <class Walk>
void on_a_grid(int exponent, std::uint64_t step, const Walk& walk) {
    for (;;) {
        const LayerSums sums = walk(exponent);
        if (sums.lost()) {
            throw RunFailure("step " + std::to_string(step) +
                             ": a force or velocity of the stress profile is not finite");
        }
        if (sums.largest() < largest_layer_term) {
            return;
        }
        exponent -= std::ilogb(sums.largest() / largest_layer_term) + 1;
    }
}

void add_kinetic(const State& state, const Layers& layers, StressProfile& profile) {
    const Particles& particles = state.particles;
    double largest = 1e-12;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        largest =
            std::max(largest, particles.mass[static_cast<std::size_t>(i)] * particles.velocity.row(i).squaredNorm());
    }
    on_a_grid(std::isfinite(largest) ? grid_exponent(largest) : 0, state.step, [&](int exponent) {
        LayerSums sums(layers, std::ldexp(1.0, exponent));
        for (Eigen::Index i = 0; i < particles.count(); ++i) {
            const auto bead = static_cast<std::uint32_t>(i);
            if (particles.frozen[bead] == 0) {
                const Vector3 velocity = particles.velocity.row(i).transpose();
                sums.add(layers.layer(layers.height(particles, bead)),
                         tensor_of(particles.mass[bead] * velocity, velocity), 1.0);
            }
        }
        profile.kinetic = sums.values(exponent);
        return sums;
    });
}

void add_forces(const State& state, Forces& forces, const Layers& layers, StressProfile& profile) {
    const Particles& particles = state.particles;
    on_a_grid(forces.pairs().energy_exponent(), state.step, [&](int exponent) {
        const double scale = std::ldexp(1.0, exponent);
        std::vector<LayerSums> pairs(static_cast<std::size_t>(thread_limit()), LayerSums(layers, scale));
        LayerSums terms(layers, scale);
        PairLines lines(layers, particles, pairs);
        forces.pairs().visit(state.box, particles, lines);
        if (BondedForces* bonded = forces.bonded()) {
            TermLines visitor(layers, particles, pairs.front(), terms);
            bonded->visit(state.box, particles, forces.pairs().table(), state.step, visitor);
        }
        for (std::size_t k = 1; k < pairs.size(); ++k) {
            pairs.front().add(pairs[k]);
        }
        profile.conservative = pairs.front().values(exponent);
        profile.bonded = terms.values(exponent);
        terms.add(pairs.front());  // for the largest of both
        return terms;
    });
}

}  // namespace

StressProfile stress_profile(const State& state, Forces& forces, int axis, std::int32_t count) {
    const Layers layers(state.box, axis, count);
    const auto species = static_cast<std::size_t>(forces.pairs().table().species());
    StressProfile profile;
    profile.beads.assign(layers.count() * species, 0);
    for (Eigen::Index i = 0; i < state.particles.count(); ++i) {
        const auto bead = static_cast<std::uint32_t>(i);
        const std::size_t layer = layers.layer(layers.height(state.particles, bead));
        ++profile.beads[layer * species + static_cast<std::size_t>(state.particles.species[bead])];
    }
    add_kinetic(state, layers, profile);
    add_forces(state, forces, layers, profile);
    return profile;
}

}  // namespace dlpoly
