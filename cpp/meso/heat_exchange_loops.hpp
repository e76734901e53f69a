// The loops of the exchange of heat over pairs that share no bead; the formulas are in heat_exchange.hpp. Compiled for
// every instruction set, as the pair laws are; all give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meso/heat_pairs.hpp"

namespace dlpoly {

// Of many pairs; arrays hold batch_lanes more than `count`, whose indices are legal.
struct HeatWeights {
    const double* squared;  // distances
    const std::uint32_t* term;
    std::size_t count;
    const HeatPair* pairs;  // by term
    double timestep;
    double* weight;  // w_T² Δt
};
struct HeatWords {
    const std::uint32_t* first;  // sorted indices
    const std::uint32_t* second;
    const std::uint32_t* image;  // nullptr: pairs have one image only
    std::size_t count;
    const std::uint32_t* word;   // by bead
    const std::uint32_t* order;  // ids
    const float* quantiles;      // of normal_table()
    std::int32_t* mixed;         // words of the pairs
    double* normal;  // positive: the first bead gains; a pair's number belongs to the bead of the smaller id
};

// Of one round of pairs: the places [begin, end) of arrays that hold batch_lanes more.
struct HeatRound {
    const std::uint32_t* first;
    const std::uint32_t* second;
    const std::uint32_t* term;
    const double* weight;
    const double* normal;
    const HeatPair* pairs;
    double reference;
    double* temperature;  // by bead, in sorted order
    const double* capacity;
    const double* inverse_capacity;  // 0 where the temperature is held
};

// A pair whose gain was found and not given: a temperature is held, or an energy has to be reflected.
struct UnusualGain {
    std::size_t place;
    double gain;  // of the first bead
};

struct HeatExchangeLoops {
    // By whether all pairs are of term 0, and whether all exponents s_T are 2.
    void (*weights[2][2])(const HeatWeights&);
    // Also those of words in the tails of the table, which are not right yet.
    void (*normals)(const HeatWords&);
    // By whether all pairs are of term 0. Returns the number of unusual gains, for at most heat_round_capacity pairs.
    std::size_t (*exchange[2])(const HeatRound&, std::size_t begin, std::size_t end, UnusualGain* unusual);
};

inline constexpr std::size_t heat_round_capacity = 128;

const HeatExchangeLoops& heat_exchange_loops();

}  // namespace dlpoly
