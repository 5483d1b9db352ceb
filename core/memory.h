#pragma once
#include <malloc.h>

namespace anyrate {

/// Returns to the system what has been freed. Between stages that each need much and keep little: glibc would hold on
/// to the holes that the first left, and the second would grow the process beyond them.
inline void give_back_freed_memory() { malloc_trim(0); }

}  // namespace anyrate
