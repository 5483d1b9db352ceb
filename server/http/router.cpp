#include "server/http/router.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <set>
#include <string_view>

#include "server/http/problem.h"

namespace anyrate {
namespace {

using Captured = std::map<std::string, std::string>;

/// Takes the next segment, without its slash, off a path.
std::string_view next_segment(std::string_view& path) {
    path.remove_prefix(1);
    const auto end = std::min(path.find('/'), path.size());
    const std::string_view segment = path.substr(0, end);
    path.remove_prefix(end);
    return segment;
}

bool is_name(std::string_view segment) { return segment.size() > 2 && segment.front() == '{' && segment.back() == '}'; }

bool is_tail(std::string_view segment) { return is_name(segment) && segment.find("...}") != std::string_view::npos; }

std::optional<Captured> match(std::string_view pattern, std::string_view path) {
    Captured captured;
    while (!pattern.empty() && !path.empty()) {
        const std::string_view expected = next_segment(pattern);
        if (is_tail(expected)) {
            path.remove_prefix(1);
            if (path.empty()) return std::nullopt;
            captured.emplace(expected.substr(1, expected.size() - 5), path);
            return captured;
        }
        const std::string_view segment = next_segment(path);
        if (is_name(expected) && !segment.empty())
            captured.emplace(expected.substr(1, expected.size() - 2), segment);
        else if (expected != segment)
            return std::nullopt;
    }
    if (!pattern.empty() || !path.empty()) return std::nullopt;
    return captured;
}

bool answers(const Route& route, const std::string& method) {
    return route.method == method || (route.method == "GET" && method == "HEAD");
}

std::string joined(const std::set<std::string>& methods) {
    std::string list;
    for (const std::string& method : methods) list += (list.empty() ? "" : ", ") + method;
    return list;
}

}  // namespace

std::size_t Router::number_of(const std::string& pattern) const {
    const auto route =
        std::find_if(routes_.begin(), routes_.end(), [&](const Route& r) { return r.pattern == pattern; });
    assert(route != routes_.end());
    return static_cast<std::size_t>(route - routes_.begin());
}

const Route& Router::find(Request& request) const {
    std::set<std::string> allowed;
    for (const Route& route : routes_) {
        auto captured = match(route.pattern, request.path);
        if (!captured) continue;
        if (answers(route, request.method)) {
            request.captured = std::move(*captured);
            return route;
        }
        allowed.insert(route.method);
        if (route.method == "GET") allowed.insert("HEAD");
    }
    if (allowed.empty()) throw HttpProblem(404, "there is nothing at " + request.path);
    throw HttpProblem(405, request.method + " is not possible at " + request.path + "; possible: " + joined(allowed),
                      {{"Allow", joined(allowed)}});
}

}  // namespace anyrate
