#pragma once
#include <cstdint>

namespace anyrate {

/// Bytes of a TCP connection that the other side has acknowledged, which is what it has taken: the kernel's own buffer
/// hides that from who writes. 0 if the kernel does not tell.
std::uint64_t n_bytes_acknowledged(int socket);

}  // namespace anyrate
