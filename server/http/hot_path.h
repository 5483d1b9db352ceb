#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "server/http/hot_logs.h"
#include "server/http/message.h"

namespace anyrate {

/// An answer that needs no wait: the header's bytes, and the body's as they lie in memory and file.
struct HotAnswer {
    int status = 200;
    std::size_t n_request_bytes = 0;  ///< of the request that it answers, from the start of what was received
    FileBody body;
};

/// The plainest and most frequent request, answered without the parser, the router and their memory: GET of a whole
/// sealed log that is in `logs`, or of one range of it, by HTTP/1.1 with no field but Accept*, Connection: keep-alive,
/// Host, Range and User-Agent. What it answers is what the general path would.
/// @param received  what came from the client
/// @param header    is replaced by the answer's header
/// @return nullopt if it is another request, or not whole: for the general path
std::optional<HotAnswer> answer_hot(std::string_view received, HotLogs& logs, std::string& header);

}  // namespace anyrate
