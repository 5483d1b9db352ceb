#include "server/http/request_id.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdint>

#include "server/store/model_id.h"

namespace anyrate {
namespace {

bool is_id(std::string_view text) {
    return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    });
}

/// Random for each process, so that ids of two runs differ.
const std::string& prefix() {
    static const std::string text = new_model_id().substr(0, 8) + "-";
    return text;
}

}  // namespace

std::string request_id_of(const Request& request) {
    const std::string_view given = request.headers.find("X-Request-Id").value_or("");
    return is_id(given) ? std::string(given) : fresh_request_id();
}

std::string fresh_request_id() {
    static std::atomic<std::uint64_t> n_requests = 0;
    char number[20];
    const auto end = std::to_chars(number, number + sizeof number, ++n_requests).ptr;
    return prefix() + std::string(number, end);
}

}  // namespace anyrate
