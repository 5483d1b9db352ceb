#pragma once

namespace anyrate {

/// Four floats in one register of any x86-64 or ARM: vector extension of GCC and Clang, whose arithmetic is that of
/// four floats, one by one.
using Float4 = float __attribute__((vector_size(16)));

}  // namespace anyrate
