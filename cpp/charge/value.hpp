// What a function of the distance between two charges returns.
#pragma once

namespace dlpoly::charge {

// u(r) and −u'(r)/r of two unit charges; the energy is q_i q_j u and the force on i is q_i q_j times the factor times
// r_i − r_j.
struct Value {
    double energy;
    double factor;
};

}  // namespace dlpoly::charge
