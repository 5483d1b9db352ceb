#pragma once
#include <cstdint>
#include <string>

namespace anyrate {

struct ListenAddress {
    std::string address;  ///< an IP address, without brackets
    std::uint16_t port = 0;
};

/// Takes "127.0.0.1:8080" or "[::1]:8080" apart. @throws InputError
ListenAddress parse_listen_address(const std::string& text);

}  // namespace anyrate
