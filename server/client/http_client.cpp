#include "server/client/http_client.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "server/client/client_stream.h"

namespace anyrate {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using ErrorCode = boost::system::error_code;
using Parser = http::response_parser<http::buffer_body>;

constexpr std::size_t max_text = 16u << 20;

template <class Body>
void fill(http::request<Body>& message, const ClientRequest& request, const Url& server, const ServerAccess& access) {
    message.method_string(request.method);
    message.target(request.target);
    message.version(11);
    message.set(http::field::host, server.authority());
    message.set(http::field::user_agent, "anyrate");
    if (!access.token.empty()) message.set(http::field::authorization, "Bearer " + access.token);
    for (const auto& [name, value] : request.headers) message.set(name, value);
}

}  // namespace

struct HttpClient::State {
    State(Url where, ClientOptions how) : server(std::move(where)), options(std::move(how)), link(options.link) {}

    Url server;
    ClientOptions options;
    Link link;
    asio::io_context io{1};
    std::optional<ClientStream> stream;
    beast::flat_buffer buffer;
    std::unique_ptr<Parser> parser;  ///< of the response that is being read
    std::uint64_t n_received = 0;

    /// Runs one asynchronous operation to its end, within the patience.
    template <class Start>
    ErrorCode run(const Start& start) {
        ErrorCode result = asio::error::would_block;
        if (stream) stream->expires_after(options.patience);
        start([&result](ErrorCode error, auto&&...) { result = error; });
        io.restart();
        io.run();
        return result;
    }
    void expect(ErrorCode error, const char* what) {
        if (!error) return;
        close();
        throw IoError(std::string("cannot ") + what + " " + server.authority() + ": " + error.message());
    }

    void connect() {
        stream.emplace(io, server, options.access);
        try {
            stream->connect(options.patience);
        } catch (const IoError&) {
            close();
            throw;
        }
        link.round_trip();
        if (server.is_secure) link.round_trip();  // TLS greets once more
        buffer.clear();
    }
    void close() {
        parser.reset();
        stream.reset();
    }

    ErrorCode send(const ClientRequest& request) {
        if (!request.body) {
            http::request<http::empty_body> message;
            fill(message, request, server, options.access);
            if (request.method == "POST") message.prepare_payload();
            return run([&](auto done) { http::async_write(*stream, message, std::move(done)); });
        }
        http::request<http::file_body> message;
        fill(message, request, server, options.access);
        ErrorCode error;
        message.body().open(request.body->c_str(), beast::file_mode::scan, error);
        if (error) throw IoError("cannot open " + request.body->string() + ": " + error.message());
        message.prepare_payload();
        http::request_serializer<http::file_body> serializer(message);
        while (!serializer.is_done() && !error)  // each piece has the patience anew
            error = run([&](auto done) { http::async_write_some(*stream, serializer, std::move(done)); });
        return error;
    }
    ErrorCode read_header(const ClientRequest& request) {
        link.round_trip();
        parser = std::make_unique<Parser>();
        parser->body_limit(std::numeric_limits<std::uint64_t>::max());
        parser->skip(request.method == "HEAD");
        return run([&](auto done) { http::async_read_header(*stream, buffer, *parser, std::move(done)); });
    }
    /// A kept connection may have been closed by the server meanwhile; a fresh one gets the request then.
    void exchange(const ClientRequest& request) {
        if (stream) {
            const ErrorCode sent = send(request);
            if (!sent && !read_header(request)) return;
            close();
        }
        connect();
        const ErrorCode sent = send(request);
        // A server that refuses a body answers before it has read it: the answer is worth a look even then.
        const ErrorCode answered = read_header(request);
        if (answered) expect(sent ? sent : answered, "get an answer of");
    }
};

HttpClient::HttpClient(const Url& server, ClientOptions options)
    : state_(std::make_unique<State>(server, std::move(options))) {}

HttpClient::~HttpClient() = default;

ClientResponse HttpClient::open(const ClientRequest& request) {
    const bool is_reusable = state_->parser && state_->parser->is_done() && state_->parser->keep_alive();
    if (!is_reusable) state_->close();
    state_->exchange(request);
    const auto& message = state_->parser->get();
    return {.status = static_cast<int>(message.result_int()),
            .etag = std::string(message[http::field::etag]),
            .location = std::string(message[http::field::location]),
            .content_range = std::string(message[http::field::content_range])};
}

std::vector<std::byte> HttpClient::read(std::size_t n) {
    State& state = *state_;
    std::vector<std::byte> bytes(n);
    std::size_t got = 0;
    while (got < n && !state.parser->is_done()) {
        auto& body = state.parser->get().body();
        body = {.data = bytes.data() + got, .size = n - got, .more = true};
        ErrorCode error =
            state.run([&](auto done) { http::async_read_some(*state.stream, state.buffer, *state.parser, done); });
        if (error == http::error::need_buffer) error = {};
        state.link.take(n - body.size - got);
        got = n - body.size;
        state.expect(error, "read from");
    }
    bytes.resize(got);
    state.n_received += got;
    return bytes;
}

std::string HttpClient::read_text() {
    const auto bytes = read(max_text);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint64_t HttpClient::n_received() const { return state_->n_received; }

std::string problem_sentence(int status, const std::string& body) {
    const auto document = nlohmann::json::parse(body, nullptr, false);
    if (document.is_object() && document.contains("detail") && document["detail"].is_string())
        return document["detail"].get<std::string>();
    return "the server answered with status " + std::to_string(status);
}

void throw_problem(HttpClient& client, const ClientResponse& response) {
    const std::string sentence = problem_sentence(response.status, client.read_text());
    if (response.status >= 400 && response.status < 500) throw InputError(sentence);
    throw IoError(sentence);
}

}  // namespace anyrate
