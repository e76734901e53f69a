// What a pass over the pairs is told: plain pointers and numbers, so that the translation units that are compiled for
// one instruction set share no inline function of the standard library with the others.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fast/records.hpp"

// Short functions of the inner loops; without this, compilers stop inlining once a loop is instantiated many times.
#if defined(__GNUC__) || defined(__clang__)
#define DLPOLY_INLINE inline __attribute__((always_inline))
#else
#define DLPOLY_INLINE inline
#endif

namespace dlpoly::fast {

// Constants of a pair of kinds, scaled so that the impulse of a pair in one step, in units of the fixed-point momentum
// and per unit of fixed-point distance, is w/r · (repulsion + noise · word − drag · w · (r·Δv)/r).
template <class Arithmetic>
struct PairRow {
    Arithmetic repulsion[most_kinds];
    Arithmetic drag[most_kinds];
    Arithmetic noise[most_kinds];
    Arithmetic inverse_cutoff[most_kinds];
    Arithmetic energy[most_kinds];  // ½ a r_c
};

// What one bead's neighbours add up to in an observed step: energy, then xx yy zz xy xz yz of the conservative, drag
// and noise virials, each in its own unit (see FluidOf::observe_totals). Every pair is counted from both of its beads.
inline constexpr int observed_numbers = 19;

// What becomes of the impulses of a pass that is not the last of a chunk.
enum class Stage {
    advance,       // momentum and position take them
    advance_held,  // the same, and what is held
    noise_alone,   // they are all there is for the estimate before one drag: a quarter; the rest is held
    noise,         // the same before two drags: all is held
    drag,          // half of these and of what is held make the next estimate
    predict,       // momentum and position take them; the drag of the next pass sees a part of them more
};

template <class Record>
struct PassArguments {
    using Arithmetic = typename Record::Arithmetic;

    const Record* sorted;          // beads in cell order, padded by `padding` records
    Record* advanced;              // out: the same beads after the step, not yet in the new order
    const std::uint8_t* shadow_x;  // 8 bits of each coordinate, for the search
    const std::uint8_t* shadow_y;
    const std::uint8_t* shadow_z;
    const std::int32_t* row_start;  // first bead of each cell; cells of a row are consecutive, one entry past the end
    const std::int32_t* row_rank;   // place of row (z · rows_y + y) in memory
    const std::int32_t* row_at;     // row at each place
    std::int32_t cells_x, rows_y, rows_z;
    std::int32_t cells_a_block;      // cells along a row whose beads share their candidates
    const std::uint8_t* distance_x;  // 128 entries each: squared shadow distance, rounded down, clipped at 255
    const std::uint8_t* distance_y;
    const std::uint8_t* distance_z;
    std::uint8_t threshold;  // sum of three entries up to which a pair may be in range

    Arithmetic metric_x, metric_y, metric_z;  // squared length of one unit of fixed-point distance
    const PairRow<Arithmetic>* rows;          // one a kind
    const Arithmetic* inverse_mass;           // one a kind, relative to the momentum unit; 0 for frozen kinds
    const Arithmetic* drift;                  // fixed-point distance a step per unit of momentum, one a kind
    std::int32_t* images;                     // 3 a bead, by id

    std::uint32_t word_key[3];  // of the next step's random words
    std::int32_t* cell_of;      // out: cell of each advanced bead, where the record has no room for it
    std::int32_t* histogram;    // in/out: beads in each cell

    // A thermostat step in the middle of a drift takes several passes at the same positions (integrate/middle.hpp). All
    // but the last leave beads where they are and write an estimate of the momentum; `held` keeps the rest.
    Stage stage;
    typename Record::Fixed* held;  // 4 a bead, in the order of `sorted`; nullptr where nothing is held
    // With a prediction, momenta in `sorted` are ahead by what is held; `held_next` is in the order of `advanced`.
    typename Record::Fixed* held_next;
    Arithmetic prediction;  // λ − ½: the part of a step's impulse by which momenta are ahead

    std::int64_t* bonded;  // impulses of bonded terms, 3 a bead by id below bonded_end, used up; or nullptr
    std::uint32_t bonded_end;
    std::int64_t* impulses;  // last step: out, 3 a bead by id
    double* observed;        // observed step: out, observed_numbers a row of cells
    void* workspace;         // buffers of the calling thread, workspace_bytes
    std::uint64_t overflow;  // out: not 0 when a momentum left its range
};

inline constexpr int padding = 256;
inline constexpr int most_candidates = 256;  // of a block; more: the block takes the direct way
inline constexpr int most_accepted = 64;     // of a bead; more: the bead takes the direct way
inline constexpr std::size_t workspace_bytes = 192 * 1024;

// What distinguishes the loops that are compiled apart.
struct Variant {
    bool one_kind;  // no lookup of kinds
    bool drag;      // drag and noise
    bool observe;   // energies and virials
    bool last;      // impulses are kept instead of being used: the chunk ends here
};

template <class Record>
using Pass = void (*)(PassArguments<Record>& arguments, std::int32_t first_place, std::int32_t last_place);

// The passes of one instruction set.
struct Passes {
    const char* name;
    Pass<MixedRecord> (*mixed)(Variant);
    Pass<DoubleRecord> (*in_double)(Variant);
};

const Passes& plain_passes();
const Passes* avx2_passes();  // nullptr when not built or not supported by this processor
const Passes* avx512_passes();

}  // namespace dlpoly::fast
