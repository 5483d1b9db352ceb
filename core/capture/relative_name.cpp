#include "core/capture/relative_name.h"

#include <algorithm>
#include <cstddef>

namespace anyrate {

std::optional<std::string> relative_name(std::string_view name) {
    const auto is_forbidden = [](char c) { return c == '\\' || static_cast<unsigned char>(c) < 0x20; };
    if (name.starts_with('/') || std::any_of(name.begin(), name.end(), is_forbidden)) return std::nullopt;

    std::string clean;
    for (std::size_t begin = 0; begin <= name.size();) {
        const std::size_t end = std::min(name.find('/', begin), name.size());
        const std::string_view part = name.substr(begin, end - begin);
        begin = end + 1;
        if (part == "..") return std::nullopt;
        if (part.empty() || part == ".") continue;
        if (!clean.empty()) clean += '/';
        clean += part;
    }
    const bool has_drive = clean.size() >= 2 && clean[1] == ':';  // also where it stood behind a "./"
    if (clean.empty() || has_drive) return std::nullopt;
    return clean;
}

}  // namespace anyrate
