#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "server/client/link.h"
#include "server/client/server_access.h"
#include "server/client/trace.h"
#include "server/client/url.h"

namespace anyrate {

struct LiveOptions {
    std::uint32_t max_vertices = 0xFFFFFFFF;
    int max_reconnects = 10;  ///< in a row without a new frame
    ServerAccess access = {};
    LinkOptions link = {};
};

/// Follows a model's log over a WebSocket until the budget is met or the model ends. A broken connection is made anew
/// and goes on behind the last whole frame; a log that was begun anew is started again.
/// @param model_target  /v1/models/{id}
/// @return the live form of the log: header and whole frames
/// @throws InputError no such model, or it failed (with its sentence); DecodeError; IoError the server stays away
std::vector<std::byte> follow_live(const Url& server, const std::string& model_target, const LiveOptions& options,
                                   ArrivalTrace& trace);

}  // namespace anyrate
