// What live clients send over their WebSocket.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "server/http/live_message.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    anyrate::parse_live_message({reinterpret_cast<const char*>(data), size});
    return 0;
}
