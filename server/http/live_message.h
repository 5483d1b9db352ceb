#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace anyrate {

/// What a live client may say: {"vertices": N} raises its budget, {"pause": true|false} holds it back or lets it go on.
struct LiveMessage {
    std::optional<std::uint32_t> max_vertices;
    std::optional<bool> pause;
};

/// @return nullopt if the text is no such message; members that are not known are passed over
std::optional<LiveMessage> parse_live_message(std::string_view text);

}  // namespace anyrate
