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
