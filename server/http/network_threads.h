#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/http/net.h"
#include "server/http/network_thread.h"

namespace anyrate {

/// The threads that serve connections, and which of them gets the next one.
///
/// If there are as many threads as processors that this process may use, each stays on one of them, and a connection
/// goes to the thread of the processor on which its packets arrive: answering a request and sending the answer then
/// touch what lies in that processor's cache already, and nobody has to be woken on another one.
class NetworkThreads {
public:
    explicit NetworkThreads(int n);

    NetworkThread& first() { return *threads_.front(); }
    /// The thread that a connection goes to.
    NetworkThread& of(tcp::socket& accepted);
    void start();
    void stop();

private:
    std::vector<std::unique_ptr<NetworkThread>> threads_;
};

/// The thread with the fewest connections, or `home` while it has not many more.
/// @param n_connections  of each thread; not empty
/// @param home           the thread that has most to hand, if there is one
std::size_t choose_thread(std::span<const std::size_t> n_connections, std::optional<std::size_t> home);

}  // namespace anyrate
