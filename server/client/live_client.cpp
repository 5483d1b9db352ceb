#include "server/client/live_client.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "core/error.h"
#include "proto/log_reader.h"
#include "server/client/client_stream.h"
#include "server/client/http_client.h"

namespace anyrate {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using ErrorCode = boost::system::error_code;

constexpr auto patience = std::chrono::seconds(30);

/// A WebSocket whose every step has a deadline.
class Socket {
public:
    Socket(const Url& server, const std::string& target, const LiveOptions& options)
        : link_(options.link), socket_(io_, server, options.access) {
        socket_.next_layer().connect(patience);
        socket_.next_layer().expires_never();
        link_.round_trip();
        if (server.is_secure) link_.round_trip();  // TLS greets once more
        socket_.set_option(websocket::stream_base::timeout{
            .handshake_timeout = patience, .idle_timeout = patience * 2, .keep_alive_pings = true});
        if (!options.access.token.empty())
            socket_.set_option(websocket::stream_base::decorator([&options](websocket::request_type& request) {
                request.set(beast::http::field::authorization, "Bearer " + options.access.token);
            }));
        socket_.read_message_max(80u << 20);  // a frame is 64 MB at most (FORMAT.md, "Limits")
        handshake(server, target);
        link_.round_trip();
    }

    struct Message {
        bool is_text = false;
        std::string bytes;
    };
    /// The next message. @throws IoError the connection is over
    Message read() {
        beast::flat_buffer buffer;
        expect(run([&](auto done) { socket_.async_read(buffer, std::move(done)); }));
        link_.take(buffer.size());
        return {socket_.got_text(), beast::buffers_to_string(buffer.data())};
    }

private:
    void handshake(const Url& server, const std::string& target) {
        websocket::response_type response;
        const ErrorCode error =
            run([&](auto done) { socket_.async_handshake(response, server.authority(), target, std::move(done)); });
        const int status = static_cast<int>(response.result_int());
        if (error == websocket::error::upgrade_declined && status >= 400 && status < 500)
            throw InputError(problem_sentence(status, response.body()));
        expect(error);
    }
    template <class Start>
    ErrorCode run(const Start& start) {
        ErrorCode result = asio::error::would_block;
        start([&result](ErrorCode error, auto&&...) { result = error; });
        io_.restart();
        // Not run(): the idle timer of the WebSocket never ends.
        while (result == asio::error::would_block) io_.run_one();
        return result;
    }
    static void expect(ErrorCode error) {
        if (error) throw IoError("the live connection broke: " + error.message());
    }

    Link link_;
    asio::io_context io_{1};
    websocket::stream<ClientStream> socket_;
};

/// What a client has of a log, and whether it was told the end.
struct Follower {
    std::string log_id;
    std::vector<std::byte> log;
    bool has_ended = false;
    ArrivalTrace& trace;

    /// Frames end where their messages end, so what is here is whole frames always.
    std::uint32_t next_sequence() const {
        std::uint32_t next = 0;
        if (!log.empty())
            for (const FrameInfo& frame : read_layout(log).frames) next = frame.sequence + 1;
        return next;
    }

    void take_text(const std::string& text) {
        const auto message = nlohmann::json::parse(text, nullptr, false);
        const std::string type = message.is_object() ? message.value("type", "") : "";
        if (type == "hello" && message.value("log_id", "") != log_id) begin(message);
        if (type == "end") end(message);
    }
    void take_frames(const std::string& bytes) {
        const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
        log.insert(log.end(), begin, begin + bytes.size());
        trace.note(log.size());
    }

private:
    void begin(const nlohmann::json& hello) {
        const bool resumes = hello.value("next_sequence", 0u) > 0;
        log.clear();
        trace.begin_anew();
        log_id = resumes ? "" : hello.value("log_id", "");
        if (resumes) throw IoError("the log was begun anew");
    }
    void end(const nlohmann::json& message) {
        has_ended = true;
        const std::string state = message.value("state", "");
        if (state == "failed" || state == "cancelled" || state == "deleted")
            throw InputError("the model " + state + ": " + message.value("error", "there will be no log"));
    }
};

/// Follows over one connection until it ends. @throws IoError it broke
void follow_once(Follower& follower, const Url& server, const std::string& model_target, const LiveOptions& options) {
    Socket socket(server,
                  model_target + "/live?vertices=" + std::to_string(options.max_vertices) +
                      "&from=" + std::to_string(follower.next_sequence()),
                  options);
    while (!follower.has_ended) {
        const Socket::Message message = socket.read();
        if (message.is_text)
            follower.take_text(message.bytes);
        else
            follower.take_frames(message.bytes);
    }
}

}  // namespace

std::vector<std::byte> follow_live(const Url& server, const std::string& model_target, const LiveOptions& options,
                                   ArrivalTrace& trace) {
    Follower follower{.log_id = {}, .log = {}, .has_ended = false, .trace = trace};
    int n_failures = 0;
    while (!follower.has_ended) {
        const std::size_t before = follower.log.size();
        try {
            follow_once(follower, server, model_target, options);
        } catch (const UntrustedServer&) {
            throw;
        } catch (const IoError&) {
            n_failures = follower.log.size() > before ? 1 : n_failures + 1;
            if (n_failures > options.max_reconnects) throw;
            std::this_thread::sleep_for(std::chrono::milliseconds(100) * (1 << std::min(n_failures, 5)));
        }
    }
    return std::move(follower.log);
}

}  // namespace anyrate
