// Threads through OpenMP where the compiler has it; one thread elsewhere.
#pragma once

#ifdef _OPENMP
#include <omp.h>
#endif

namespace dlpoly {

// Upper bound of thread_number() in the next parallel region.
inline int thread_limit() noexcept {
#ifdef _OPENMP
    return omp_get_max_threads();
#else
    return 1;
#endif
}

inline int thread_number() noexcept {
#ifdef _OPENMP
    return omp_get_thread_num();
#else
    return 0;
#endif
}

inline void set_threads([[maybe_unused]] int threads) noexcept {
#ifdef _OPENMP
    omp_set_num_threads(threads);
#endif
}

inline bool has_threads() noexcept {
#ifdef _OPENMP
    return true;
#else
    return false;
#endif
}

}  // namespace dlpoly
