#pragma once

namespace anyrate {

/// Four floats in one register of any x86-64 or ARM: vector extension of GCC and Clang, whose arithmetic is that of
/// four floats, one by one.
using Float4 = float __attribute__((vector_size(16)));

inline float sum_of_lanes(const Float4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace anyrate
