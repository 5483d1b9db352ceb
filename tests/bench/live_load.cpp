#include "tests/bench/live_load.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/error.h"

namespace anyrate::bench {
namespace {

int connect_to(std::uint16_t port, bool is_stalled) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (socket < 0) throw IoError(std::string("no socket: ") + std::strerror(errno));
    const int least = 4096;  // so that what a stalled client does not take is held back on the server's side
    if (is_stalled) ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &least, sizeof least);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        throw IoError(std::string("cannot connect: ") + std::strerror(errno));
    return socket;
}

/// Answers a ping, without which a server takes the client for gone. Those of this server say nothing to repeat.
void send_pong(int socket) {
    const unsigned char pong[6] = {0x8A, 0x80};  // masked by zeros
    ::send(socket, pong, sizeof pong, MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace

LiveLoad::LiveLoad(LiveLoadOptions options) : options_(std::move(options)), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    buffer_.resize(256 * 1024);
    clients.resize(static_cast<std::size_t>(options_.n_clients));
    for (std::size_t i = 0; i < clients.size(); ++i) {
        // Spread among the others, for servers may treat connections in their order.
        const auto n_stalled = static_cast<std::size_t>(options_.n_stalled);
        clients[i].is_stalled = (i * n_stalled) / clients.size() != ((i + 1) * n_stalled) / clients.size();
        clients[i].socket = connect_to(options_.port, clients[i].is_stalled);
        if (clients[i].is_stalled) continue;
        clients[i].arrivals.reserve(options_.frame_ends.size());
        epoll_event event{.events = EPOLLIN, .data = {.u64 = i}};
        ::epoll_ctl(epoll_, EPOLL_CTL_ADD, clients[i].socket, &event);
    }
}

LiveLoad::~LiveLoad() {
    for (const LiveClient& client : clients) ::close(client.socket);
    ::close(epoll_);
}

void LiveLoad::ask() {
    const std::string request = "GET " + options_.target +
                                " HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    for (LiveClient& client : clients)
        if (::send(client.socket, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
            end(client);
}

void LiveLoad::wait_until_open(Clock::duration patience) {
    const auto deadline = Clock::now() + patience;
    const auto is_open = [](const LiveClient& client) { return client.is_open || client.is_stalled; };
    while (!std::all_of(clients.begin(), clients.end(), is_open)) {
        if (Clock::now() > deadline) throw IoError("not every client got its WebSocket in time");
        read_ready(50);
    }
}

bool LiveLoad::read_to_end(Clock::duration patience) {
    const auto deadline = Clock::now() + patience;
    const auto has_ended = [](const LiveClient& client) { return client.has_ended || client.is_stalled; };
    while (!std::all_of(clients.begin(), clients.end(), has_ended)) {
        if (Clock::now() > deadline) return false;
        read_ready(50);
    }
    return true;
}

void LiveLoad::read_ready(int patience_ms) {
    epoll_event events[512];
    const int n = ::epoll_wait(epoll_, events, 512, patience_ms);
    for (int i = 0; i < n; ++i) read(clients[events[i].data.u64]);
}

void LiveLoad::read(LiveClient& client) {
    const ssize_t n = ::recv(client.socket, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) return end(client);
    take(client, {buffer_.data(), static_cast<std::size_t>(n)}, Clock::now());
}

void LiveLoad::take(LiveClient& client, std::span<const char> bytes, Clock::time_point now) {
    while (!bytes.empty() && !client.has_ended) {
        std::size_t n = 0;
        if (!client.is_open)
            n = take_http(client, bytes);
        else if (client.payload_left == 0)
            n = take_frame_head(client, bytes);
        else
            n = take_payload(client, bytes, now);
        bytes = bytes.subspan(n);
    }
}

std::size_t LiveLoad::take_http(LiveClient& client, std::span<const char> bytes) {
    constexpr std::string_view empty_line = "\r\n\r\n";
    const std::size_t before = client.head.size();
    client.head.append(bytes.data(), bytes.size());
    const auto at = client.head.find(empty_line);
    if (at == std::string::npos) return bytes.size();
    const std::size_t used = at + empty_line.size() - before;
    client.is_open = client.head.find(" 101 ") != std::string::npos;
    if (!client.is_open) end(client);
    client.head.clear();
    return used;
}

std::size_t LiveLoad::take_frame_head(LiveClient& client, std::span<const char> bytes) {
    std::size_t used = 0;
    const auto needed = [&] {
        if (client.head.size() < 2) return std::size_t(2);
        const int length = client.head[1] & 0x7F;  // a server masks nothing
        return std::size_t(length == 126 ? 4 : length == 127 ? 10 : 2);
    };
    while (used < bytes.size() && client.head.size() < needed()) client.head += bytes[used++];
    if (client.head.size() < needed()) return used;
    const auto byte = [&](std::size_t i) { return std::uint64_t(static_cast<unsigned char>(client.head[i])); };
    client.opcode = static_cast<int>(byte(0) & 0x0F);
    client.payload_left = byte(1) & 0x7F;
    if (client.head.size() > 2) {
        client.payload_left = 0;
        for (std::size_t i = 2; i < client.head.size(); ++i) client.payload_left = client.payload_left << 8 | byte(i);
    }
    client.head.clear();
    ++client.n_messages;
    if (client.opcode == 8) end(client);
    if (client.opcode == 9) send_pong(client.socket);
    return used;
}

std::size_t LiveLoad::take_payload(LiveClient& client, std::span<const char> bytes, Clock::time_point now) {
    const std::size_t n = std::min<std::uint64_t>(client.payload_left, bytes.size());
    client.payload_left -= n;
    if (client.opcode != 2 && client.opcode != 0) return n;
    const std::uint64_t end = client.n_bytes + n;
    if (end > options_.log.size() || std::memcmp(options_.log.data() + client.n_bytes, bytes.data(), n) != 0)
        client.is_wrong = true;
    client.n_bytes = end;
    for (; client.n_frames < options_.frame_ends.size() && options_.frame_ends[client.n_frames] <= end;
         ++client.n_frames)
        client.arrivals.push_back(now);
    return n;
}

void LiveLoad::end(LiveClient& client) {
    client.has_ended = true;
    client.ended_at = Clock::now();
    ::epoll_ctl(epoll_, EPOLL_CTL_DEL, client.socket, nullptr);
}

}  // namespace anyrate::bench
