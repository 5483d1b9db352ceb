#pragma once
#include <filesystem>
#include <string>

#include "core/error.h"

namespace anyrate {

/// What a client shows to a server, and how it knows the server.
struct ServerAccess {
    std::string token = {};  ///< sent as bearer token with every request; empty for none
    std::filesystem::path ca =
        {};  ///< certificates (PEM) that an https server's must come from; empty for the system's
};

/// The server has no certificate for its name that this client trusts. Asking again helps nobody.
struct UntrustedServer : IoError {
    using IoError::IoError;
};

}  // namespace anyrate
