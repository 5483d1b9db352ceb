#pragma once
#include <cstdint>

namespace anyrate {

/// Four doubles, and four integers of their size: vector extension of GCC and Clang. One register where there is AVX2
/// (vector_clones.h), two elsewhere; either way the arithmetic is that of four doubles, one by one.
using Double4 = double __attribute__((vector_size(32), aligned(32)));
using Long4 = std::int64_t __attribute__((vector_size(32), aligned(32)));

}  // namespace anyrate
