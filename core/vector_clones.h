#pragma once

/// Before a function whose loops a compiler can vectorise: GCC makes one version for AVX2 and one for any x86-64, and
/// the program picks one when it starts. Both do the same IEEE operations, so they give the same bytes. Elsewhere there
/// is one version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ANYRATE_VECTOR_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define ANYRATE_VECTOR_CLONES
#endif

/// Before a loop whose iterations touch no memory of each other, which GCC then need not prove.
#if defined(__clang__)
#define ANYRATE_INDEPENDENT_ITERATIONS
#else
#define ANYRATE_INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif
