#include "server/http/hot_path.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include "server/http/file_response.h"
#include "server/http/http_date.h"
#include "server/http/range.h"
#include "server/http/request_id.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

constexpr std::string_view line_end = "\r\n";
constexpr std::size_t max_request = 2048;

/// What a request says that may be answered here.
struct PlainRequest {
    std::string_view model_id, range;  ///< range empty if there is none
    bool has_range = false, has_host = false;
    std::size_t n_bytes = 0;
};

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_name(std::string_view name, std::string_view expected) {
    return name.size() == expected.size() &&
           std::equal(name.begin(), name.end(), expected.begin(), [](char a, char b) { return lower(a) == b; });
}

bool is_plain_text(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c < 0x7F; });
}

/// The id in `GET /v1/models/<id>/log HTTP/1.1`.
std::optional<std::string_view> model_of(std::string_view line) {
    constexpr std::string_view begin = "GET /v1/models/", end = "/log HTTP/1.1";
    constexpr std::size_t id_size = 26;
    if (line.size() != begin.size() + id_size + end.size() || line.substr(0, begin.size()) != begin ||
        line.substr(begin.size() + id_size) != end)
        return std::nullopt;
    const std::string_view id = line.substr(begin.size(), id_size);
    return is_model_id(id) ? std::optional(id) : std::nullopt;
}

/// @return false if the field is none that may be passed over here
bool take_field(PlainRequest& request, std::string_view line) {
    constexpr std::array<std::string_view, 4> passed_over = {"user-agent", "accept", "accept-encoding",
                                                             "accept-language"};
    const auto colon = line.find(": ");
    if (colon == std::string_view::npos || !is_plain_text(line)) return false;
    const std::string_view name = line.substr(0, colon), value = line.substr(colon + 2);
    if (same_name(name, "range") && !request.has_range) {
        request.has_range = true;
        request.range = value;
        return true;
    }
    if (same_name(name, "host")) return !std::exchange(request.has_host, true);
    if (same_name(name, "connection")) return same_name(value, "keep-alive");
    return std::any_of(passed_over.begin(), passed_over.end(),
                       [&](std::string_view known) { return same_name(name, known); });
}

std::optional<PlainRequest> parse(std::string_view received) {
    PlainRequest request;
    std::string_view rest = received.substr(0, max_request);
    const auto next_line = [&]() -> std::optional<std::string_view> {
        const auto end = rest.find(line_end);
        if (end == std::string_view::npos) return std::nullopt;
        const std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end + line_end.size());
        return line;
    };
    const auto first = next_line();
    const auto id = first ? model_of(*first) : std::nullopt;
    if (!id) return std::nullopt;
    request.model_id = *id;
    for (auto line = next_line(); line; line = next_line()) {
        if (line->empty()) {
            if (!request.has_host) return std::nullopt;
            request.n_bytes = std::min(received.size(), max_request) - rest.size();
            return request;
        }
        if (!take_field(request, *line)) return std::nullopt;
    }
    return std::nullopt;
}

void append(std::string& text, std::uint64_t number) {
    char digits[20];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

}  // namespace

std::optional<HotAnswer> answer_hot(std::string_view received, HotLogs& logs, std::string& header) {
    const auto request = parse(received);
    if (!request) return std::nullopt;
    const auto log = logs.find(request->model_id);
    if (!log) return std::nullopt;
    const std::uint64_t size = log->view.size;
    HotAnswer answer{.n_request_bytes = request->n_bytes, .body = {log->view.file, 0, size, log->bytes}};
    if (request->has_range) {
        const RangeAnswer range = parse_range(request->range, size);
        const auto* part = std::get_if<ByteRange>(&range);
        if (!part) return std::nullopt;
        answer.status = 206;
        answer.body.begin = part->begin;
        answer.body.n_bytes = part->end - part->begin;
    }
    header = answer.status == 206 ? "HTTP/1.1 206 Partial Content\r\n" : "HTTP/1.1 200 OK\r\n";
    header += "Server: anyrate\r\nDate: ";
    header += http_date();
    header += "\r\nX-Content-Type-Options: nosniff\r\nETag: ";
    header += log->etag;
    header +=
        "\r\nCache-Control: public, max-age=31536000, immutable\r\nAccept-Ranges: bytes\r\n"
        "Content-Type: model/vnd.anyrate\r\n";
    if (answer.status == 206) {
        header += "Content-Range: bytes ";
        append(header, answer.body.begin);
        header += '-';
        append(header, answer.body.begin + answer.body.n_bytes - 1);
        header += '/';
        append(header, size);
        header += line_end;
    }
    header += "X-Request-Id: ";
    header += fresh_request_id();
    header += "\r\nContent-Length: ";
    append(header, answer.body.n_bytes);
    header += "\r\n\r\n";
    return answer;
}

}  // namespace anyrate
