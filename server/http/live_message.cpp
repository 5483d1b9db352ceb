#include "server/http/live_message.h"

#include <nlohmann/json.hpp>

namespace anyrate {

std::optional<LiveMessage> parse_live_message(std::string_view text) {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) return std::nullopt;
    LiveMessage message;
    if (const auto vertices = json.find("vertices"); vertices != json.end()) {
        if (!vertices->is_number_unsigned() || *vertices > UINT32_MAX) return std::nullopt;
        message.max_vertices = vertices->get<std::uint32_t>();
    }
    if (const auto pause = json.find("pause"); pause != json.end()) {
        if (!pause->is_boolean()) return std::nullopt;
        message.pause = pause->get<bool>();
    }
    return message;
}

}  // namespace anyrate
