// Which scenes the fast path takes: refusal() of fluid.hpp.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "fast/fluid.hpp"
#include "fast/kinds.hpp"
#include "fast/records.hpp"

namespace dlpoly::fast {

namespace {

// Why fixed-point numbers would round away what happens in a step; empty when they do not. A momentum, an impulse and a
// move that are usual in the scene must be at least so many of their units.
std::string coarse(const Box& box, const Kinds& kinds, const PairTable& table, const StepSettings& settings,
                   double range) {
    constexpr double least = 256.0;
    const bool mixed = settings.precision == Precision::mixed;
    const int momentum_bits = mixed ? MixedRecord::momentum_bits : DoubleRecord::momentum_bits;
    const int position_bits = mixed ? MixedRecord::position_bits : DoubleRecord::position_bits;
    const double momentum_unit = std::ldexp(1.0, std::ilogb(range) + 1 - momentum_bits);
    const double position_unit = std::ldexp(box.cell().diagonal().maxCoeff(), -position_bits);
    double lightest = std::numeric_limits<double>::infinity();
    double heaviest = 0.0;
    for (const Kinds::Kind& kind : kinds.list) {
        if (!kind.frozen) {
            lightest = std::min(lightest, kind.mass);
            heaviest = std::max(heaviest, kind.mass);
        }
    }
    const double energy = range * range / (1600.0 * heaviest);  // see momentum_range
    const double momentum = std::sqrt(lightest * energy);
    const double move = settings.timestep * std::sqrt(energy / heaviest);
    const double impulse = settings.timestep * energy / table.range();
    if (!(momentum >= least * momentum_unit)) {
        return "the masses are too unlike for fixed-point momenta";
    }
    if (!(impulse >= least * momentum_unit) || !(move >= least * position_unit)) {
        return "the timestep is too short for fixed-point numbers";
    }
    return {};
}

}  // namespace

std::string refusal(const Box& box, const Particles& particles, const PairTable& table, const StepSettings& settings,
                    bool has_external_fields) {
    const Matrix3& cell = box.cell();
    const Matrix3 diagonal = cell.diagonal().asDiagonal();
    const std::array<bool, 3>& periodic = box.periodic();
    if (!(periodic[0] && periodic[1] && periodic[2])) {
        return "the box is open along an axis";
    }
    if (cell != diagonal || !(cell.diagonal().minCoeff() > 0.0)) {
        return "the cell is not orthorhombic";
    }
    if (settings.barostat.acts()) {
        return "the cell follows the pressure";
    }
    if (settings.shear_rate != 0.0) {
        return "the cell is sheared";
    }
    if (settings.flight) {
        return "beads do not fly along straight lines";
    }
    if (has_external_fields) {
        return "there is an external field";
    }
    if (!table.is_soft()) {
        return "a pair law is not the soft repulsion dpd, or its drag ends elsewhere";
    }
    if (!(table.range() > 0.0)) {
        return "nothing interacts";
    }
    if (!(cell.diagonal().minCoeff() >= 4.0 * table.range())) {
        return "the box is shorter than four cutoffs";
    }
    // Positions are fractions of the box of 32 or 48 bits.
    const double longest = settings.precision == Precision::mixed ? 512.0 : 2048.0;
    if (cell.diagonal().maxCoeff() > longest * table.range()) {
        return "the box is too long for fixed-point positions";
    }
    if (settings.order != Order::velocity_verlet && settings.order != Order::middle) {
        return "the integrator is not nve, mdvv or middle";
    }
    if (settings.schedule.varies()) {
        return "the temperature varies";
    }
    if (settings.drag && settings.weight_exponent != 2.0) {
        return "the weight exponent is not 2";
    }
    if (settings.remove_drift) {
        return "the drift is removed in every step";
    }
    if (settings.force_cap > 0.0 && settings.equilibration_steps > 0) {
        return "forces are capped";
    }
    if (particles.count() >= static_cast<Eigen::Index>(id_mask)) {
        return "there are too many beads";
    }
    const double density = static_cast<double>(particles.count()) / box.volume();
    double cell_volume = 1.0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        cell_volume *= cell(axis, axis) / std::floor(cell(axis, axis) / table.range());
    }
    const double neighbours = 4.0 / 3.0 * pi * density * std::pow(table.range(), 3);
    if (candidates_of_block(1.0, density * cell_volume) > usual_candidates || neighbours > 0.75 * most_accepted) {
        return "beads have too many neighbours";
    }
    const Kinds kinds = find_kinds(particles, most_kinds);
    if (kinds.list.empty()) {
        return "there are no beads, or more than 16 combinations of species, mass and frozen";
    }
    const double range = momentum_range(kinds, table, settings.thermal_energy);
    if (!(range > 0.0)) {
        return "there is neither a temperature nor a repulsion to choose a range of momenta from";
    }
    return coarse(box, kinds, table, settings, range);
}

}  // namespace dlpoly::fast
