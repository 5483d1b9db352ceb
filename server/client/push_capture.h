#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "server/client/server_access.h"
#include "server/client/url.h"

namespace anyrate {

struct PushOptions {
    std::optional<int> n_vertices;
    ServerAccess access = {};
};

/// Uploads a capture: a zip at once, a folder file by file. A request that broke is repeated; of a folder whose upload
/// broke before, also in another process, only the files are sent that have not arrived. The server makes one model all
/// the same.
/// @return the id of the model @throws InputError the server refuses, with its sentence; IoError
std::string push_capture(const Url& server, const std::filesystem::path& capture, const PushOptions& options);

/// A model's state as the server tells it.
struct RemoteState {
    std::string state, stage, error;
    double fraction = 0;
    std::uint64_t n_vertices = 0, n_bytes = 0;
};

/// Asks for the state twice a second until it is final. @param on_change  called at each new answer
/// @throws InputError there is no such model, IoError the server does not answer for a minute
RemoteState wait_for_model(const Url& server, const std::string& id, const ServerAccess& access,
                           const std::function<void(const RemoteState&)>& on_change);

}  // namespace anyrate
