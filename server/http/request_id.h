#pragma once
#include <string>

#include "server/http/message.h"

namespace anyrate {

/// The name of a request in logs and in the answer's X-Request-Id: the client's own if it sent one of up to 64 letters,
/// digits, "-" and "_", else a fresh one.
std::string request_id_of(const Request& request);
std::string fresh_request_id();

}  // namespace anyrate
