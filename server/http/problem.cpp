#include "server/http/problem.h"

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace anyrate {

std::string status_phrase(int status) {
    switch (status) {
        case 400:
            return "Bad Request";
        case 401:
            return "Unauthorized";
        case 403:
            return "Forbidden";
        case 404:
            return "Not Found";
        case 405:
            return "Method Not Allowed";
        case 408:
            return "Request Timeout";
        case 409:
            return "Conflict";
        case 411:
            return "Length Required";
        case 413:
            return "Content Too Large";
        case 414:
            return "URI Too Long";
        case 415:
            return "Unsupported Media Type";
        case 416:
            return "Range Not Satisfiable";
        case 422:
            return "Unprocessable Content";
        case 426:
            return "Upgrade Required";
        case 431:
            return "Request Header Fields Too Large";
        case 500:
            return "Internal Server Error";
        case 501:
            return "Not Implemented";
        case 503:
            return "Service Unavailable";
        case 507:
            return "Insufficient Storage";
        default:
            return "Error";
    }
}

Response problem_response(const HttpProblem& problem) {
    nlohmann::ordered_json document = {{"type", "about:blank"},
                                       {"title", status_phrase(problem.status)},
                                       {"status", problem.status},
                                       {"detail", problem.what()}};
    for (const auto& [path, sentence] : problem.faults)
        document["faults"].push_back({{"path", path}, {"fault", sentence}});
    Response response{.status = problem.status, .headers = problem.headers, .body = {}};
    response.headers.add("Content-Type", "application/problem+json");
    response.headers.add("Cache-Control", "no-store");
    response.body = document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    return response;
}

HttpProblem to_problem(std::exception_ptr error) {
    try {
        std::rethrow_exception(error);
    } catch (const HttpProblem& problem) {
        return problem;
    } catch (const InputError& input) {
        return {400, input.what()};
    } catch (const DiskFull&) {
        return {507, "the server's disk is full; delete models or try again later", {{"Retry-After", "10"}}};
    } catch (const IoError&) {
        return {503, "the server's storage does not answer; try again later", {{"Retry-After", "10"}}};
    } catch (...) {
        return {500, "the server failed at this request"};
    }
}

}  // namespace anyrate
