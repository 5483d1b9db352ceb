#pragma once
#include <functional>
#include <string>

#include "server/http/access_record.h"

namespace anyrate {

enum class LogFormat { plain, json };
enum class LogRequests { none, errors, all };  ///< errors: answers from 400 on

/// Where a server's news goes: standard error, a line each, safe to use from several threads. As JSON a line is
/// {"time", "level", "message"}, for a request also "request_id", "client", "method", "path", "status", "bytes" and
/// "seconds", with "error" if something failed inside.
struct ServerLog {
    std::function<void(const std::string&)> line;
    std::function<void(const AccessRecord&)> request;  ///< empty if none are logged
    int from_status = 0;                               ///< those that are
};

ServerLog make_server_log(LogFormat format, LogRequests requests);

}  // namespace anyrate
