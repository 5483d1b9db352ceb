#include "server/http/tcp_progress.h"

// The kernel's own header: that of the C library does not know the field, and the two cannot stand in one file.
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace anyrate {

TcpProgress tcp_progress(int socket) {
    tcp_info info{};
    socklen_t n_bytes = sizeof info;
    if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &n_bytes) != 0) return {};
    return {.n_acknowledged = info.tcpi_bytes_acked,
            .owes_nothing = info.tcpi_unacked == 0 && info.tcpi_notsent_bytes == 0};
}

}  // namespace anyrate
