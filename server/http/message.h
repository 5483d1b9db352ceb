#pragma once
// Requests and responses as handlers see them: plain data, no socket.
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "proto/index.h"
#include "server/store/file.h"

namespace anyrate {

/// Header fields in order; names compare without case.
class Headers {
public:
    Headers() = default;
    Headers(std::initializer_list<std::pair<std::string, std::string>> fields) : fields_(fields) {}

    void add(std::string name, std::string value) { fields_.emplace_back(std::move(name), std::move(value)); }
    /// The first field of that name.
    std::optional<std::string_view> find(std::string_view name) const;
    auto begin() const { return fields_.begin(); }
    auto end() const { return fields_.end(); }

private:
    std::vector<std::pair<std::string, std::string>> fields_;
};

/// A request body that was streamed to a file; the handler may move the file, what is left is removed after it.
struct Upload {
    std::filesystem::path file;
    std::uint64_t n_bytes = 0;
};

struct Request {
    std::string method = "GET";
    std::string path = "/";                            ///< decoded, without the query
    std::map<std::string, std::string> query = {};     ///< decoded
    std::map<std::string, std::string> captured = {};  ///< what the route's {names} stood for
    Headers headers = {};
    std::optional<Upload> upload = {};
};

/// Bytes of an open file.
struct FileBody {
    std::shared_ptr<const FileHandle> file;
    std::uint64_t begin = 0, n_bytes = 0;
    std::shared_ptr<const std::vector<std::byte>> memory = {};  ///< the whole file, if it is in memory
};

/// The answer goes on as a WebSocket that sends frames as they are made.
struct LiveBody {
    std::string model_id;
    std::uint32_t max_vertices = 0xFFFFFFFF;
    std::uint32_t from = 0;  ///< sequence number of the first frame that is wanted
};

/// The answer goes on as Server-Sent Events of the model's state.
struct EventsBody {
    std::string model_id;
};

struct Response {
    int status = 200;
    Headers headers = {};
    std::variant<std::string, FileBody, LiveBody, EventsBody> body = {};
};

}  // namespace anyrate
