#include "server/http/range.h"

#include <algorithm>
#include <charconv>

namespace anyrate {
namespace {

std::string_view trim(std::string_view text) {
    const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

std::optional<std::uint64_t> parse_number(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc::result_out_of_range && end == text.data() + text.size()) return UINT64_MAX;
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

RangeAnswer suffix(std::uint64_t n, std::uint64_t size) {
    if (n == 0 || size == 0) return Unsatisfiable{};
    return ByteRange{size - std::min(n, size), size};
}

}  // namespace

RangeAnswer parse_range(std::string_view field, std::uint64_t size) {
    constexpr std::string_view unit = "bytes=";
    field = trim(field);
    if (field.substr(0, unit.size()) != unit) return WholeBody{};
    const std::string_view range = trim(field.substr(unit.size()));
    const auto dash = range.find('-');
    if (dash == std::string_view::npos) return WholeBody{};

    const std::string_view first = range.substr(0, dash), last = range.substr(dash + 1);
    const auto begin = parse_number(first), final = parse_number(last);
    if (first.empty()) return final ? suffix(*final, size) : RangeAnswer(WholeBody{});
    if (!begin || (!last.empty() && !final)) return WholeBody{};
    if (final && *final < *begin) return WholeBody{};
    if (*begin >= size) return Unsatisfiable{};
    return ByteRange{*begin, final ? std::min(*final, size - 1) + 1 : size};
}

bool matches_etag(std::string_view field, std::string_view etag) {
    if (trim(field) == "*") return true;
    while (!field.empty()) {
        const auto comma = field.find(',');  // our tags hold no comma, so a tag with one cannot match in part
        std::string_view candidate = trim(field.substr(0, comma));
        if (candidate.substr(0, 2) == "W/") candidate.remove_prefix(2);
        if (candidate == etag) return true;
        field = comma == std::string_view::npos ? std::string_view() : field.substr(comma + 1);
    }
    return false;
}

bool if_range_holds(std::string_view field, std::string_view etag) { return trim(field) == etag; }

}  // namespace anyrate
