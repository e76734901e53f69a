// The inner loops of the pair forces, compiled once for every instruction set of the processor family; the best set
// that the processor has is chosen at run time. All sets give the same bits: additions and products are never fused.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "forces/pair_batch.hpp"

namespace dlpoly {

// A bead in sorted order. `lattice` counts the cells it has crossed since the pair list was built, in the numbering of
// the list's lattice vectors.
struct alignas(32) BeadRecord {
    double x, y, z;
    int64_t lattice;
};

// A bead's velocity and its random word of the step.
struct alignas(32) MotionRecord {
    double x, y, z;
    uint64_t word;
};

struct alignas(32) ShiftRecord {
    double x, y, z, unused;
};

// A second bead of the pair list and the number of the lattice vector to add to it when the list was built.
struct ListEntry {
    uint32_t bead;
    uint32_t image;
};

// The neighbours of one bead for one entry of the pair table. Their number is rounded up to whole lanes; the entries
// that fill up name a bead that is nowhere.
struct ListSegment {
    uint32_t bead;
    uint32_t first;
    uint32_t end;
};

// Beads [begin, end) in sorted order, seen with one lattice vector.
struct CandidateRange {
    uint32_t begin;
    uint32_t end;
    uint32_t image;
};

struct SearchArguments {
    const double* x;  // in sorted order, readable batch_lanes past the end
    const double* y;
    const double* z;
    const ShiftRecord* shifts;
    double limit_squared;
};

struct FilterArguments {
    const BeadRecord* beads;
    const ShiftRecord* shifts;
    int64_t zero;  // number of the lattice vector 0
    bool images;   // whether the batch's images are wanted
    const ListEntry* entries;
    const ListSegment* segments;
    // Where the filter stands; it stops when the batch is full.
    size_t segment;
    size_t last_segment;
    uint32_t entry;  // next entry of the segment
};

// Tells several images of one pair apart, for a lattice vector and its opposite.
struct ImageCodes {
    uint8_t code[2];
};

struct MotionArguments {
    const MotionRecord* beads;
    const ImageCodes* image_codes;  // by number of the lattice vector; nullptr: pairs have one image only
    const uint32_t* ids;            // of beads in sorted order
    double drag;
    double noise;                  // σ
    double inverse_root_timestep;  // 1/√Δt
    double cutoff;
};

// Rounded sums of an observed batch: energy, then the six different entries (xx xy xz yy yz zz) of three virials.
struct ObservedSums {
    int64_t energy;
    int64_t virial[3][6];
};

struct Phases {
    const char* name;
    // Writes every bead of the ranges closer than the limit to `bead`; returns the end of what was written. Needs room
    // for all candidates and batch_lanes more.
    ListEntry* (*search)(const SearchArguments&, uint32_t bead, const CandidateRange* ranges, size_t count,
                         ListEntry* out);
    // Appends pairs within the batch's reach to it; true when it came to the last segment's end.
    bool (*filter)(FilterArguments&, PairBatch&);
    // Drag and noise with w^R = 1 − r/r_c and mixed words.
    void (*motion)(const MotionArguments&, const PairBatch&, BatchResult&);
    // Rounds the pair forces to the grid; false when a force is beyond it or not a number.
    bool (*round)(const PairBatch&, BatchResult&, bool motion, double scale);
    // Adds the rounded forces to the beads.
    void (*add)(const PairBatch&, const BatchResult&, GridForce* sums);
    // Sums energy and virials; false when a term is beyond the grid or not a number.
    bool (*observe)(const PairBatch&, const BatchResult&, bool motion, double scale, ObservedSums& sums);
};

const Phases& plain_phases();
const Phases* avx2_phases();    // nullptr: not built in, or the processor lacks it
const Phases* avx512_phases();  // likewise

// The best the processor has, or the one that the environment variable PYDLPOLY_SIMD names.
const Phases& chosen_phases();

// Of three versions of the same, the one for the instruction set of chosen_phases().
template <class Version>
const Version& chosen_version(const Version& plain, const Version& avx2, const Version& avx512) {
    const Phases* chosen = &chosen_phases();
    return chosen == avx512_phases() ? avx512 : chosen == avx2_phases() ? avx2 : plain;
}

// The chosen of the loops that DLPOLY_LOOPS_FOR_EVERY_SET has defined.
#ifdef DLPOLY_LAW_VECTORS
#define DLPOLY_CHOSEN_LOOPS chosen_version(plain_loops, avx2_loops, avx512_loops)
#else
#define DLPOLY_CHOSEN_LOOPS plain_loops
#endif

}  // namespace dlpoly
