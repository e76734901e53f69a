// What every pair thermostat of the splitting kind is made of: a map of the relative velocity of a pair along its axis,
// u → keep · u + add, that leaves the Maxwell distribution of u (variance k_B T/μ, μ the reduced mass) as it is.
// One map = one header in this folder.
#pragma once

namespace dlpoly::sweep {

// Everything a map may depend on.
struct PairSituation {
    double drag = 0.0;            // γ, Da/ps
    double weight = 0.0;          // w^D(r) = (1 − r/r_c)^s
    double inverse_mass = 0.0;    // 1/μ = 1/m_i + 1/m_j, 1/Da
    double duration = 0.0;        // h, ps
    double thermal_energy = 0.0;  // k_B T

    // γ w^D h/μ: how often the pair's relative velocity would relax in this time.
    [[nodiscard]] double relaxation() const noexcept { return drag * weight * duration * inverse_mass; }
};

// Two independent random numbers of the pair: a standard normal one and a uniform one in (0, 1).
struct PairDraw {
    double normal = 0.0;
    double uniform = 0.0;
};

struct LinearMap {
    double keep = 1.0;
    double add = 0.0;  // Å/ps
};

}  // namespace dlpoly::sweep
