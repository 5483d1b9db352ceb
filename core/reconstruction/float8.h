#pragma once
#include <cstdint>

namespace anyrate {

/// Eight floats, and eight integers of their size: vector extension of GCC and Clang. One register where there is AVX2
/// (vector_clones.h), two elsewhere; either way the arithmetic is that of eight floats, one by one.
/// Aligned by name: where there is no AVX the compiler would take half of it, and a version for AVX2 needs it all.
using Float8 = float __attribute__((vector_size(32), aligned(32)));
using Int8 = std::int32_t __attribute__((vector_size(32), aligned(32)));

}  // namespace anyrate
