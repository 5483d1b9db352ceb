#pragma once
#include <cstdint>

namespace anyrate {

/// What the peer of a TCP connection has taken.
struct TcpProgress {
    std::uint64_t n_acknowledged = 0;  ///< bytes since the connection began
    bool owes_nothing = true;          ///< all that was sent is acknowledged
};

/// @return as if nothing had ever been sent, if the kernel does not tell
TcpProgress tcp_progress(int socket);

}  // namespace anyrate
