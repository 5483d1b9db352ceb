#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "server/client/server_access.h"

namespace CLI {
class App;
}

namespace anyrate {

/// The options of commands that talk to a server: its token and its certificates.
class AccessOptions {
public:
    /// Must outlive the parsing.
    void add_to(CLI::App& app);
    /// What was given. @throws InputError the token's file cannot be read, or holds none
    ServerAccess access() const;

private:
    std::string token_;
    std::optional<std::filesystem::path> token_file_;
    std::filesystem::path ca_;
};

}  // namespace anyrate
