#include "server/http/multipart.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <optional>

#include "server/http/problem.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

constexpr std::size_t max_parts = 20'000;
constexpr std::size_t max_part_header = 8 * 1024;

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

/// Takes a parameter's value, a token or a quoted string, off the front.
std::optional<std::string> take_value(std::string_view& text) {
    std::string value;
    if (text.empty() || text.front() != '"') {
        const auto end = std::min(text.find(';'), text.size());
        value = std::string(trim(text.substr(0, end)));
        text.remove_prefix(end);
        return value;
    }
    for (text.remove_prefix(1); !text.empty(); text.remove_prefix(1)) {
        if (text.front() == '"') {
            text.remove_prefix(1);
            return value;
        }
        if (text.front() == '\\' && text.size() > 1) text.remove_prefix(1);
        value += text.front();
    }
    return std::nullopt;  // the string does not end
}

/// The value of a parameter of a header field `value; name=...; name="..."`; nullopt if it is not there.
/// @throws HttpProblem
std::optional<std::string> parameter(std::string_view field, std::string_view name) {
    field.remove_prefix(std::min(field.find(';'), field.size()));
    std::optional<std::string> found;
    while (!field.empty()) {
        field.remove_prefix(1);
        const auto equals = field.find('=');
        if (equals == std::string_view::npos) return found;
        const std::string key = lower(trim(field.substr(0, equals)));
        field.remove_prefix(equals + 1);
        auto value = take_value(field);
        if (!value) throw HttpProblem(400, "a quoted string in a multipart header does not end");
        if (key == name && !found) found = std::move(value);
        field.remove_prefix(std::min(field.find(';'), field.size()));
    }
    return found;
}

FormPart part_of(std::string_view head, std::string_view body) {
    FormPart part{.name = {}, .filename = {}, .content_type = {}, .bytes = as_bytes(body)};
    while (!head.empty()) {
        const auto end = std::min(head.find("\r\n"), head.size());
        const std::string_view line = head.substr(0, end);
        head.remove_prefix(std::min(end + 2, head.size()));
        const auto colon = line.find(':');
        if (colon == std::string_view::npos)
            throw HttpProblem(400, "a line of a part's header has no colon: expected a field as in \"Name: value\"");
        const std::string name = lower(trim(line.substr(0, colon)));
        const std::string_view value = trim(line.substr(colon + 1));
        if (name == "content-disposition") {
            part.name = parameter(value, "name").value_or("");
            part.filename = parameter(value, "filename").value_or("");
        } else if (name == "content-type") {
            part.content_type = lower(trim(value.substr(0, value.find(';'))));
        }
    }
    return part;
}

}  // namespace

std::string multipart_boundary(std::string_view content_type) {
    const auto boundary = parameter(content_type, "boundary");
    const auto is_allowed = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) ||
               std::string_view("'()+_,-./:=? ").find(c) != std::string_view::npos;
    };
    if (!boundary || boundary->empty() || boundary->size() > 70 || boundary->back() == ' ' ||
        !std::all_of(boundary->begin(), boundary->end(), is_allowed))
        throw HttpProblem(400, "multipart/form-data: expected a boundary of 1 to 70 characters that RFC 2046 allows");
    return *boundary;
}

std::vector<FormPart> parse_multipart(std::span<const std::byte> body, const std::string& boundary) {
    const std::string delimiter = "\r\n--" + boundary;
    const std::boyer_moore_horspool_searcher searcher(delimiter.begin(), delimiter.end());
    std::string_view rest = as_text(body);
    if (rest.substr(0, delimiter.size() - 2) != std::string_view(delimiter).substr(2))
        throw HttpProblem(400, "the multipart body does not begin with its boundary, --" + boundary);
    rest.remove_prefix(delimiter.size() - 2);
    std::vector<FormPart> parts;
    while (rest.substr(0, 2) != "--") {
        if (rest.substr(0, 2) != "\r\n")
            throw HttpProblem(400, "behind a boundary of the multipart body: expected a line's end or --");
        rest.remove_prefix(2);
        // A part without header begins with the empty line itself.
        const bool has_header = rest.substr(0, 2) != "\r\n";
        const auto head_end = has_header ? rest.substr(0, max_part_header).find("\r\n\r\n") : 0;
        if (head_end == std::string_view::npos)
            throw HttpProblem(400, "the header of a part does not end, or is longer than 8 KB");
        const std::string_view head = rest.substr(0, head_end);
        rest.remove_prefix(head_end + (has_header ? 4 : 2));
        const auto end = std::search(rest.begin(), rest.end(), searcher);
        if (end == rest.end()) throw HttpProblem(400, "the multipart body is cut off: its last boundary is not there");
        const auto n_bytes = static_cast<std::size_t>(end - rest.begin());
        if (parts.size() == max_parts) throw HttpProblem(400, "the multipart body has more than 20000 parts");
        parts.push_back(part_of(head, rest.substr(0, n_bytes)));
        rest.remove_prefix(n_bytes + delimiter.size());
    }
    return parts;
}

}  // namespace anyrate
