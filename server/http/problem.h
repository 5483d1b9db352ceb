#pragma once
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/http/message.h"

namespace anyrate {

/// Ends a request with a status, a sentence, and header fields that belong to the status (Allow, WWW-Authenticate,
/// ...).
struct HttpProblem : std::runtime_error {
    HttpProblem(int http_status, const std::string& sentence, Headers fields = {})
        : std::runtime_error(sentence), status(http_status), headers(std::move(fields)) {}
    int status;
    Headers headers;
    std::vector<std::pair<std::string, std::string>> faults = {};  ///< of a capture: path and sentence of each
};

/// The standard phrase of a status: "Not Found".
std::string status_phrase(int status);

/// A problem document (RFC 9457, application/problem+json).
Response problem_response(const HttpProblem& problem);

/// What any exception of a handler becomes, the one place where types turn into statuses: HttpProblem its own,
/// InputError 400, DiskFull 507, other IoErrors 503, everything else 500 without its words (they may tell what is
/// nobody's business).
HttpProblem to_problem(std::exception_ptr error);

}  // namespace anyrate
