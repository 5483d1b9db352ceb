#include "server/http/tcp_progress.h"

// The kernel's own header: that of the C library does not know the field, and the two cannot stand in one file.
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace anyrate {

std::uint64_t n_bytes_acknowledged(int socket) {
    tcp_info info{};
    socklen_t n_bytes = sizeof info;
    const bool known = ::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &n_bytes) == 0;
    return known ? info.tcpi_bytes_acked : 0;
}

}  // namespace anyrate
