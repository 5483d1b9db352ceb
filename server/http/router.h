#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/http/message.h"

namespace anyrate {

using Handler = std::function<Response(const Request&)>;

struct Route {
    std::string method;   ///< GET also answers HEAD
    std::string pattern;  ///< "/v1/models/{id}/log": a {name} stands for one non-empty segment, {name...} for the rest
    Handler handle;
    bool takes_upload = false;  ///< the body is streamed to a file before handle(); else there is none
    bool is_heavy = false;      ///< computes for long: runs apart from the quick ones
    std::function<void(const Request&)> check = {};  ///< of what can be refused before the body is read
    /// Answers without any wait, if it can; tried on the network thread before handle(). Throws nothing but
    /// HttpProblem.
    std::function<std::optional<Response>(const Request&)> answer_at_once = {};
};

/// Finds the route of a request.
class Router {
public:
    explicit Router(std::vector<Route> routes) : routes_(std::move(routes)) {}

    /// The route of a method and path; `request.captured` gets what its {names} stand for.
    /// @throws HttpProblem 404 no route has the path, 405 (with Allow) one has, but not for this method
    const Route& find(Request& request) const;
    const std::vector<Route>& routes() const { return routes_; }
    std::size_t number_of(const std::string& pattern) const;  ///< of the first route of a pattern that is there
    std::size_t number_of(const Route& route) const { return static_cast<std::size_t>(&route - routes_.data()); }

private:
    std::vector<Route> routes_;
};

}  // namespace anyrate
