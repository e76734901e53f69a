// The fast path takes over a state and gives it back (see fluid_of.hpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/failure.hpp"
#include "fast/fluid_of.hpp"
#define DLPOLY_SIMD plain
#include "fast/pass.hpp"

namespace dlpoly::fast {

namespace {

[[noreturn]] void report_range(std::uint64_t step, Eigen::Index bead) {
    const std::string who = bead < 0 ? "a bead" : "bead " + std::to_string(bead + 1);
    throw RunFailure("step " + std::to_string(step) + ": the momentum of " + who +
                     " left its range, 40 times the thermal one; the timestep is too long for the forces, or precision "
                     "reference is needed, which has no such range");
}

}  // namespace

// Reads the state into records. With impulses, the state is at the end of an earlier chunk, and the beads are advanced
// to the first positions at which new impulses are needed.
template <class Record>
void FluidOf<Record>::take(State& state, const StepSettings& settings, bool with_impulses) {
    Particles& particles = state.particles;
    const double timestep = scheme_.timestep;
    const double largest = std::ldexp(1.0, Record::momentum_bits);
    std::vector<std::int32_t>& histogram = beads_.restart();
    PassArguments<Record> step = arguments(state);
    set_word_key(step, settings, with_impulses ? state.step + 1 : state.step);
    step.drift = scheme_.thermostat_due(state.step + 1) ? constants_.half_drift.data() : constants_.drift.data();
    const auto beads = static_cast<Eigen::Index>(beads_.count());
    Record* records = beads_.advanced();
    for (Eigen::Index i = 0; i < beads; ++i) {
        const auto id = static_cast<std::size_t>(i);
        const std::uint8_t kind = kinds_.of_bead[id];
        Record& bead = records[i];
        bead = Record{};
        bead.tag = (static_cast<std::uint32_t>(kind) << kind_shift) | static_cast<std::uint32_t>(i);
        std::array<Fixed*, 3> position{&bead.x, &bead.y, &bead.z};
        std::array<Fixed*, 3> momentum{&bead.px, &bead.py, &bead.pz};
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            const double scale = std::ldexp(1.0, Record::position_bits) / units_.edges[axis];
            const std::int64_t rounded = std::llrint(particles.position(i, axis) * scale);
            // The upper face is the lower one of the next image.
            if (rounded == std::int64_t{1} << (Record::position_bits - 1)) {
                particles.position(i, axis) -= units_.edges[axis];
                ++particles.image(i, axis);
            }
            *position[k] = static_cast<Fixed>(static_cast<std::uint64_t>(rounded) << unused_bits<Record>);
            if (!kinds_.list[kind].frozen) {
                const double unit = units_.momentum_along(axis);
                // Velocities of a state are those of whole steps: half an impulse ahead of the leapfrog's momentum.
                const double impulse = with_impulses ? std::rint(particles.force(i, axis) * timestep / unit) : 0.0;
                const double exact = particles.velocity(i, axis) * particles.mass[id] / unit - 0.5 * impulse;
                if (!(std::abs(exact) < largest)) {
                    report_range(state.step, i);
                }
                *momentum[k] = static_cast<Fixed>(std::llrint(exact));
            }
        }
        if (with_impulses) {
            std::array<Fixed, 4> impulse{};
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                impulse[static_cast<std::size_t>(axis)] =
                    static_cast<Fixed>(std::llrint(particles.force(i, axis) * timestep / units_.momentum_along(axis)));
            }
            const Record before = bead;
            plain::advance_bead(step, before, impulse.data(), bead);
        }
        if (scheme_.predicts) {
            Fixed* held = beads_.held_next() + 4 * id;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<std::size_t>(axis);
                const auto impulse =
                    static_cast<Fixed>(std::llrint(particles.force(i, axis) * timestep / units_.momentum_along(axis)));
                held[k] = with_impulses && !kinds_.list[kind].frozen
                              ? static_cast<Fixed>(plain::nearest(static_cast<Arithmetic>(impulse) * step.prediction))
                              : Fixed{0};
                *momentum[k] += held[k];
            }
        }
        bead.word = bead_word(static_cast<std::uint32_t>(i), step.word_key);
        const std::int32_t cell = plain::cell_of(step, bead);
        plain::keep_cell(step, static_cast<std::int32_t>(i), cell);
        ++histogram[static_cast<std::size_t>(cell)];
    }
    if (step.overflow != 0) {
        report_range(state.step, -1);
    }
}

// Writes positions and velocities of the whole step back.
template <class Record>
void FluidOf<Record>::give_motion(State& state) {
    Particles& particles = state.particles;
    const Record* records = beads_.sorted();
    for (std::size_t place = 0; place < beads_.count(); ++place) {
        const Record& bead = records[place];
        const std::size_t id = bead.tag & id_mask;
        const auto i = static_cast<Eigen::Index>(id);
        if (kinds_.list[bead.tag >> kind_shift].frozen) {
            continue;
        }
        const std::array<Fixed, 3> position{bead.x, bead.y, bead.z};
        const std::array<Fixed, 3> momentum{bead.px, bead.py, bead.pz};
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            particles.position(i, axis) = coordinate<Record>(position[k], units_.edges[axis]);
            const double half_step =
                static_cast<double>(scheme_.predicts ? momentum[k] - beads_.held()[4 * place + k] : momentum[k]);
            const double whole = half_step + 0.5 * static_cast<double>(beads_.impulses()[3 * id + k]);
            particles.velocity(i, axis) = whole * units_.momentum_along(axis) / particles.mass[id];
        }
    }
}

template <class Record>
void FluidOf<Record>::give_forces(State& state) {
    Particles& particles = state.particles;
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        const auto id = static_cast<std::size_t>(i);
        const bool frozen = particles.frozen[id] != 0;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto impulse = static_cast<double>(beads_.impulses()[3 * id + static_cast<std::size_t>(axis)]);
            particles.force(i, axis) = frozen ? 0.0 : impulse * units_.momentum_along(axis) / scheme_.timestep;
        }
    }
}

// Leaves the beads where they were after the step that failed, and names one whose momentum is out of range.
template <class Record>
void FluidOf<Record>::stop(State& state, std::uint64_t lost, std::uint64_t steps) {
    Eigen::Index first = -1;
    if (lost < steps) {  // the beads were advanced
        Particles& particles = state.particles;
        for (std::size_t k = 0; k < beads_.count(); ++k) {
            const Record& bead = beads_.advanced()[k];
            const auto id = static_cast<Eigen::Index>(bead.tag & id_mask);
            const Kinds::Kind& kind = kinds_.list[bead.tag >> kind_shift];
            const std::array<Fixed, 3> position{bead.x, bead.y, bead.z};
            const std::array<Fixed, 3> momentum{bead.px, bead.py, bead.pz};
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const auto n = static_cast<std::size_t>(axis);
                if (kind.frozen) {
                    continue;
                }
                particles.position(id, axis) = coordinate<Record>(position[n], units_.edges[axis]);
                particles.velocity(id, axis) =
                    static_cast<double>(momentum[n]) * units_.momentum_along(axis) / kind.mass;
                const bool beyond =
                    std::abs(static_cast<double>(momentum[n])) >= std::ldexp(1.0, Record::momentum_bits);
                first = beyond && (first < 0 || id < first) ? id : first;
            }
        }
    }
    state.step += lost;
    for (std::uint64_t k = 0; k < lost; ++k) {
        state.time += scheme_.timestep;
    }
    report_range(state.step, first);
}

// Σ m v_a v_b of the momenta between two force evaluations; with drag and noise in the middle, of those after them.
template <class Record>
Matrix3 FluidOf<Record>::half_step_kinetic() const {
    Matrix3 tensor = Matrix3::Zero();
    for (std::size_t place = 0; place < beads_.count(); ++place) {
        const Record& bead = beads_.sorted()[place];
        const Kinds::Kind& kind = kinds_.list[bead.tag >> kind_shift];
        if (kind.frozen) {
            continue;
        }
        const std::array<Fixed, 3> ahead{bead.px, bead.py, bead.pz};
        Vector3 momentum;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            const Fixed held = scheme_.predicts ? beads_.held()[4 * place + k] : Fixed{0};
            momentum[axis] = static_cast<double>(ahead[k] - held) * units_.momentum_along(axis);
        }
        tensor += momentum * momentum.transpose() / kind.mass;
    }
    return tensor;
}

// The members of this file; those of fluid.cpp are instantiated there.
template void FluidOf<MixedRecord>::take(State&, const StepSettings&, bool);
template void FluidOf<MixedRecord>::give_motion(State&);
template void FluidOf<MixedRecord>::give_forces(State&);
template void FluidOf<MixedRecord>::stop(State&, std::uint64_t, std::uint64_t);
template Matrix3 FluidOf<MixedRecord>::half_step_kinetic() const;
template void FluidOf<DoubleRecord>::take(State&, const StepSettings&, bool);
template void FluidOf<DoubleRecord>::give_motion(State&);
template void FluidOf<DoubleRecord>::give_forces(State&);
template void FluidOf<DoubleRecord>::stop(State&, std::uint64_t, std::uint64_t);
template Matrix3 FluidOf<DoubleRecord>::half_step_kinetic() const;

}  // namespace dlpoly::fast
