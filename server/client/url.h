#pragma once
#include <string>
#include <string_view>

namespace anyrate {

/// An http:// or https:// address taken apart.
struct Url {
    bool is_secure = false;  ///< https
    std::string host;
    std::string port = "80";
    std::string target = "/";  ///< path and query, as it stands in the address

    /// "host:port" as the Host field wants it, without the port if it is the scheme's own.
    std::string authority() const;
};

/// @throws InputError neither an http:// nor an https:// address, or one with a user name
Url parse_url(std::string_view text);

/// The target without its query.
std::string path_of(const Url& url);

}  // namespace anyrate
