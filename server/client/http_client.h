#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/client/link.h"
#include "server/client/server_access.h"
#include "server/client/url.h"

namespace anyrate {

struct ClientRequest {
    std::string method = "GET";
    std::string target = "/";
    std::vector<std::pair<std::string, std::string>> headers;
    std::optional<std::filesystem::path> body;  ///< a file that is sent
};

/// What stands before a response's body.
struct ClientResponse {
    int status = 0;
    std::string etag;
    std::string location;
    std::string content_range;
};

struct ClientOptions {
    ServerAccess access = {};
    std::chrono::seconds patience = std::chrono::seconds(30);  ///< for each step
    LinkOptions link = {};
};

/// A connection to one server, kept between requests and made anew when it broke. Every wait has a deadline.
class HttpClient {
public:
    explicit HttpClient(const Url& server, ClientOptions options = {});
    ~HttpClient();

    /// Sends a request and reads the response's header. What is left of an earlier body is given up.
    /// @throws IoError the server cannot be reached, does not answer, or is not the one it says it is (UntrustedServer)
    ClientResponse open(const ClientRequest& request);
    /// The next bytes of the body: up to `n`, fewer only where it ends. @throws IoError
    std::vector<std::byte> read(std::size_t n);
    /// The rest of the body as text, 16 MB at most. @throws IoError
    std::string read_text();

    /// Bytes of bodies received so far.
    std::uint64_t n_received() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The sentence of a problem document, or the status if it is none.
std::string problem_sentence(int status, const std::string& body);

/// Reads the body of a response that says no, and throws its sentence.
/// @throws InputError for a 4xx, IoError for every other status
[[noreturn]] void throw_problem(HttpClient& client, const ClientResponse& response);

}  // namespace anyrate
