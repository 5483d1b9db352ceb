#include "server/cli/listen_address.h"

#include <charconv>

#include "core/error.h"

namespace anyrate {

ListenAddress parse_listen_address(const std::string& text) {
    const InputError wrong("--listen " + text + ": expected an address and a port, as in 127.0.0.1:8080 or [::1]:8080");
    const auto colon = text.rfind(':');
    if (colon == std::string::npos) throw wrong;
    ListenAddress listen{.address = text.substr(0, colon)};
    const char* end = text.data() + text.size();
    const auto [parsed_end, error] = std::from_chars(text.data() + colon + 1, end, listen.port);
    if (error != std::errc() || parsed_end != end) throw wrong;
    if (listen.address.size() > 2 && listen.address.front() == '[' && listen.address.back() == ']')
        listen.address = listen.address.substr(1, listen.address.size() - 2);
    return listen;
}

}  // namespace anyrate
