// What loops that are compiled for several instruction sets ask of the compiler.
#pragma once

// A function that becomes part of its callers, and so is compiled for their instruction set; a pointer to memory that
// no other pointer of the function reaches.
#if defined(__GNUC__)
#define DLPOLY_ALWAYS_INLINE [[gnu::always_inline]] inline
#define DLPOLY_RESTRICT __restrict
#else
#define DLPOLY_ALWAYS_INLINE inline
#define DLPOLY_RESTRICT
#endif

// A function for an instruction set; `flatten` draws everything into it, so that nothing compiled for the set can be
// met elsewhere.
#ifdef DLPOLY_LAW_VECTORS
#define DLPOLY_FOR_AVX2 __attribute__((target("avx2"), flatten))
#define DLPOLY_FOR_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw"), flatten))
#endif

// LOOPS(set, attribute) defines a file's loops as `set`_loops, for every set that is built.
#ifdef DLPOLY_LAW_VECTORS
#define DLPOLY_LOOPS_FOR_EVERY_SET(LOOPS) LOOPS(plain, ) LOOPS(avx2, DLPOLY_FOR_AVX2) LOOPS(avx512, DLPOLY_FOR_AVX512)
#else
#define DLPOLY_LOOPS_FOR_EVERY_SET(LOOPS) LOOPS(plain, )
#endif
