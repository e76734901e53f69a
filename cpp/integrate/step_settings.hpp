// What every integrator is told about a step.
#pragma once

#include <cstdint>

namespace dlpoly {

// How pairs are computed. All three conserve momentum to the bit of their sums.
enum class Precision {
    reference,         // double, general path, one Gaussian number of Philox4x32-10 for every pair
    double_precision,  // pair arithmetic and sums in double
    mixed,             // pair arithmetic in single precision, exact integer sums; the general path stays in double
};

struct StepSettings {
    Precision precision = Precision::double_precision;
    double timestep = 0.0;         // ps
    double thermal_energy = 0.0;   // k_B T, internal energy
    double weight_exponent = 2.0;  // s of w^D = (1 − r/r_c)^s
    double prediction = 0.5;       // Groot–Warren's λ
    bool drag = false;             // pair thermostat on
    bool remove_drift = false;     // take the centre-of-mass velocity out in every step
    std::uint64_t seed = 0;
    std::int64_t degrees_of_freedom = 0;
    double force_cap = 0.0;                 // largest force on a bead while equilibrating, 0 = none
    std::uint64_t equilibration_steps = 0;  // first steps in which the next three act
    std::uint64_t rescale_every = 0;        // steps, 0 = never
    std::uint64_t regauss_every = 0;        // steps, 0 = never
};

}  // namespace dlpoly
