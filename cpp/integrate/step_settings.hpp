// What every integrator is told about a step.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

namespace dlpoly {

class Flight;
class HeatPairs;

// How a step is taken. The names are those of ensemble_dpd_order.
enum class Order {
    velocity_verlet,  // nve, and mdvv where there is drag
    dpdvv,
    scvv,
    zeroth,
    first,
    second,
    peters,
    peters_first,
    lowe_andersen,
    stoyanov_groot,
    ou,
    ou_middle,
    middle,
    nose_hoover_langevin,
    langevin,  // thermostats that act on single beads
    berendsen,
    hoover,
};

// A temperature that changes with time: straight lines between points, constant before and after them, or a sine.
struct TemperatureSchedule {
    std::vector<double> times;     // ps, ascending
    std::vector<double> energies;  // k_B T at those times
    double amplitude = 0.0;        // of the sine, in k_B T; added to the settings' thermal_energy
    double period = 0.0;           // ps
    double phase = 0.0;            // radians at time 0

    [[nodiscard]] bool varies() const noexcept { return !times.empty() || amplitude != 0.0; }

    [[nodiscard]] double at(double time, double thermal_energy) const noexcept {
        if (amplitude != 0.0) {
            return thermal_energy + amplitude * std::sin(2.0 * std::numbers::pi * time / period + phase);
        }
        if (times.empty()) {
            return thermal_energy;
        }
        std::size_t k = 0;
        while (k < times.size() && times[k] <= time) {
            ++k;
        }
        if (k == 0 || k == times.size()) {
            return k == 0 ? energies.front() : energies.back();
        }
        const double part = (time - times[k - 1]) / (times[k] - times[k - 1]);
        return energies[k - 1] + part * (energies[k] - energies[k - 1]);
    }
};

// Which edges of an orthorhombic cell follow the pressure.
enum class CellMotion {
    fixed,
    isotropic,  // all three by one factor
    height,     // z alone: constant area
    square,     // x and y by one factor, z by another
    edges,      // each by its own
};

// A Langevin piston: what moves the cell (see piston.hpp).
struct Barostat {
    CellMotion motion = CellMotion::fixed;
    std::array<double, 3> pressure{};  // on the faces across x, y, z
    double tension = 0.0;              // surface tension of the plane of x and y
    double relaxation = 0.0;           // ps
    double friction = 0.0;             // 1/ps
    double tail = 0.0;                 // virial of the long-range correction (−Σ r·F) times the volume

    [[nodiscard]] bool acts() const noexcept { return motion != CellMotion::fixed; }
};

// How pairs are computed. All three conserve momentum to the bit of their sums.
enum class Precision {
    reference,         // double, general path, one Gaussian number of Philox4x32-10 for every pair
    double_precision,  // pair arithmetic and sums in double
    mixed,             // pair arithmetic in single precision, exact integer sums; the general path stays in double
};

struct StepSettings {
    Precision precision = Precision::double_precision;
    double timestep = 0.0;           // ps
    double thermal_energy = 0.0;     // k_B T, internal energy
    double weight_exponent = 2.0;    // s of w^D = (1 − r/r_c)^s
    double longest_move = 0.0;       // of a bead in one step, Å: farther is a failure; 0 = no limit
    double prediction = 0.5;         // Groot–Warren's λ
    bool half_step_kinetic = false;  // the kinetic energy of mdvv is that of the half-step velocities
    Order order = Order::velocity_verlet;
    TemperatureSchedule schedule;      // of thermal_energy
    double transverse_drag = 0.0;      // γ⊥/γ of sweeps
    double collision_rate = 0.0;       // Γ of thermostats that choose pairs, 1/ps; 0 = from the drags
    double thermostat_coupling = 0.0;  // Stoyanov and Groot's α, Da/ps
    double thermostat_mass = 0.0;      // of Nosé and Hoover's variable, energy · ps² / …; see its integrator
    double thermostat_friction = 0.0;  // of the same variable, 1/ps
    double relaxation = 0.0;           // time of Berendsen's and Hoover's thermostats, ps
    double tolerance = 1e-6;           // of the self-consistent iteration: relative change of the kinetic energy
    int passes = 3;                    // pair passes of the simultaneous middle step
    int thermostat_every = 1;          // steps between two thermostat steps of the middle schemes
    bool drag = false;                 // pair thermostat on
    bool remove_drift = false;         // take the centre-of-mass velocity out in every step
    std::uint64_t seed = 0;
    std::int64_t degrees_of_freedom = 0;
    double force_cap = 0.0;                 // largest force on a bead while equilibrating, 0 = none
    std::uint64_t equilibration_steps = 0;  // first steps in which the next three act
    std::uint64_t rescale_every = 0;        // steps, 0 = never
    std::uint64_t regauss_every = 0;        // steps, 0 = never
    Barostat barostat;
    double shear_rate = 0.0;  // ∂u_x/∂y of a cell with Lees–Edwards boundaries, 1/ps
    // Coefficients of beads that carry heat; none: they do not.
    std::shared_ptr<const HeatPairs> heat;
    std::shared_ptr<const Flight> flight;  // how beads move between kicks; none: along straight lines
};

}  // namespace dlpoly
