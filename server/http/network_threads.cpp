#include "server/http/network_threads.h"

#include <sched.h>
#include <sys/socket.h>

#include <algorithm>
#include <iterator>

namespace anyrate {
namespace {

/// So many connections more than another a thread may have because they arrive on its processor.
constexpr std::size_t max_imbalance = 64;

/// Those that this process may use; empty if that cannot be told.
std::vector<int> usable_processors() {
    cpu_set_t usable;
    CPU_ZERO(&usable);
    std::vector<int> processors;
    if (::sched_getaffinity(0, sizeof usable, &usable) != 0) return processors;
    for (int processor = 0; processor < CPU_SETSIZE; ++processor)
        if (CPU_ISSET(static_cast<std::size_t>(processor), &usable)) processors.push_back(processor);
    return processors;
}

/// The processor on which the connection's packets arrive.
std::optional<int> incoming_processor(tcp::socket& socket) {
    int processor = -1;
    socklen_t n_bytes = sizeof processor;
    const bool known =
        ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_INCOMING_CPU, &processor, &n_bytes) == 0 && processor >= 0;
    return known ? std::optional(processor) : std::nullopt;
}

}  // namespace

NetworkThreads::NetworkThreads(int n) {
    const std::vector<int> processors = usable_processors();
    const bool has_one_each = processors.size() == static_cast<std::size_t>(n);
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
        threads_.push_back(std::make_unique<NetworkThread>(has_one_each ? std::optional(processors[i]) : std::nullopt));
}

NetworkThread& NetworkThreads::of(tcp::socket& accepted) {
    std::vector<std::size_t> n_connections;
    for (const auto& thread : threads_) n_connections.push_back(thread->n_connections());
    std::optional<std::size_t> home;
    if (const auto processor = incoming_processor(accepted)) {
        const auto found = std::find_if(threads_.begin(), threads_.end(),
                                        [&](const auto& thread) { return thread->processor() == processor; });
        if (found != threads_.end()) home = static_cast<std::size_t>(std::distance(threads_.begin(), found));
    }
    return *threads_[choose_thread(n_connections, home)];
}

void NetworkThreads::start() {
    for (const auto& thread : threads_) thread->start();
}

void NetworkThreads::stop() {
    for (const auto& thread : threads_) thread->stop();
}

std::size_t choose_thread(std::span<const std::size_t> n_connections, std::optional<std::size_t> home) {
    const auto fewest = std::min_element(n_connections.begin(), n_connections.end());
    if (home && n_connections[*home] <= *fewest + max_imbalance) return *home;
    return static_cast<std::size_t>(std::distance(n_connections.begin(), fewest));
}

}  // namespace anyrate
