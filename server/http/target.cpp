#include "server/http/target.h"

#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::size_t max_target = 4096;

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percent_decode(std::string_view text, bool plus_is_space) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '+' && plus_is_space) {
            decoded += ' ';
        } else if (text[i] != '%') {
            decoded += text[i];
        } else {
            const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
            const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
            if (high < 0 || low < 0)
                throw HttpProblem(400, "the request target has a % without two hexadecimal digits");
            decoded += static_cast<char>(high * 16 + low);
            i += 2;
        }
    }
    return decoded;
}

std::string decode_path(std::string_view path) {
    // An encoded slash or NUL would mean something else to a file system than to the router.
    for (const char* forbidden : {"%2f", "%2F", "%00"})
        if (path.find(forbidden) != std::string_view::npos)
            throw HttpProblem(400, std::string("the path has an encoded ") + forbidden + ", which no path here has");
    return percent_decode(path, false);
}

std::map<std::string, std::string> decode_query(std::string_view query) {
    std::map<std::string, std::string> parameters;
    while (!query.empty()) {
        const auto end = query.find('&');
        const std::string_view pair = query.substr(0, end);
        query = end == std::string_view::npos ? std::string_view() : query.substr(end + 1);
        if (pair.empty()) continue;
        const auto equals = pair.find('=');
        const std::string name = percent_decode(pair.substr(0, equals), true);
        const auto value = equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1);
        if (!parameters.emplace(name, percent_decode(value, true)).second)
            throw HttpProblem(400, "parameter \"" + name + "\" is given twice");
    }
    return parameters;
}

/// The target without the scheme and host that a proxy's client names (RFC 9112, 3.2.2).
std::string_view without_origin(std::string_view target) {
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (target.substr(0, scheme.size()) != scheme) continue;
        const auto path = target.find('/', scheme.size());
        return path == std::string_view::npos ? std::string_view("/") : target.substr(path);
    }
    return target;
}

}  // namespace

Target parse_target(std::string_view target) {
    if (target.size() > max_target) throw HttpProblem(414, "the request target is longer than 4096 bytes");
    target = without_origin(target);
    if (target.empty() || target.front() != '/') throw HttpProblem(400, "the request target must begin with a slash");
    const auto question = target.find('?');
    const auto query = question == std::string_view::npos ? std::string_view() : target.substr(question + 1);
    return {.path = decode_path(target.substr(0, question)), .query = decode_query(query)};
}

}  // namespace anyrate
