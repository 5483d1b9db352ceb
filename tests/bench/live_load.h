#pragma once
// Many live clients of one server in one thread, for load: raw sockets, for what is measured is the server.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace anyrate::bench {

using Clock = std::chrono::steady_clock;

struct LiveLoadOptions {
    std::uint16_t port = 0;  ///< on 127.0.0.1
    std::string target;      ///< "/v1/models/.../live"
    int n_clients = 0;
    int n_stalled = 0;                      ///< of them take nothing once they are connected
    std::span<const std::byte> log;         ///< what every client must be sent, byte for byte
    std::vector<std::uint64_t> frame_ends;  ///< offsets in the log whose arrivals are noted
};

/// One client's end of a WebSocket (RFC 6455): knows how far it is and whether all was right.
struct LiveClient {
    int socket = -1;
    bool is_open = false;  ///< the server agreed to the WebSocket
    bool is_stalled = false;
    bool has_ended = false;     ///< a close frame or the end of the connection came
    bool is_wrong = false;      ///< a byte was not that of the log
    std::uint64_t n_bytes = 0;  ///< of the log so far
    std::uint64_t n_messages = 0;
    std::size_t n_frames = 0;                 ///< that arrived whole
    std::vector<Clock::time_point> arrivals;  ///< of these frames
    Clock::time_point ended_at;

    // Where the parser stands.
    std::string head;  ///< of the HTTP answer or of a WebSocket frame, as far as it came
    std::uint64_t payload_left = 0;
    int opcode = 0;
};

/// The clients, which live as long as it does.
class LiveLoad {
public:
    /// Connects all clients; none has asked for anything. @throws IoError
    explicit LiveLoad(LiveLoadOptions options);
    ~LiveLoad();
    LiveLoad(const LiveLoad&) = delete;
    LiveLoad& operator=(const LiveLoad&) = delete;

    void ask();  ///< Sends every client's request for the WebSocket.
    /// Reads until every client that is not stalled has its WebSocket. @throws IoError `patience` ran out
    void wait_until_open(Clock::duration patience);
    /// Reads until every client that is not stalled has ended, or `patience` ran out. @return whether they had
    bool read_to_end(Clock::duration patience);

    std::vector<LiveClient> clients;

private:
    void read_ready(int patience_ms);
    void read(LiveClient& client);
    void take(LiveClient& client, std::span<const char> bytes, Clock::time_point now);
    std::size_t take_http(LiveClient& client, std::span<const char> bytes);
    std::size_t take_frame_head(LiveClient& client, std::span<const char> bytes);
    std::size_t take_payload(LiveClient& client, std::span<const char> bytes, Clock::time_point now);
    void end(LiveClient& client);

    LiveLoadOptions options_;
    int epoll_ = -1;
    std::vector<char> buffer_;
};

}  // namespace anyrate::bench
