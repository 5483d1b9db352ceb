#include "server/http/query.h"

#include <algorithm>
#include <charconv>
#include <string>

#include "server/http/problem.h"

namespace anyrate {
namespace {

const std::string* find(const Request& request, const char* name) {
    const auto parameter = request.query.find(name);
    return parameter == request.query.end() ? nullptr : &parameter->second;
}

std::optional<double> query_positive(const Request& request, const char* name) {
    const std::string* text = find(request, name);
    if (!text) return std::nullopt;
    double value = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    // "nan" and "inf" parse as numbers, the comparison refuses them.
    if (error != std::errc() || end != text->data() + text->size() || !(value >= 0 && value < 1e300))
        throw HttpProblem(400, std::string(name) + "=" + *text + ": expected a number that is not negative");
    return value;
}

}  // namespace

void expect_only(const Request& request, std::initializer_list<std::string_view> names) {
    for (const auto& [name, value] : request.query)
        if (std::find(names.begin(), names.end(), name) == names.end())
            throw HttpProblem(400, "unknown parameter \"" + name + "\"");
}

std::optional<std::uint64_t> query_integer(const Request& request, const char* name, std::uint64_t low,
                                           std::uint64_t high) {
    const std::string* text = find(request, name);
    if (!text) return std::nullopt;
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (error != std::errc() || end != text->data() + text->size() || value < low || value > high)
        throw HttpProblem(400, std::string(name) + "=" + *text + ": expected a whole number from " +
                                   std::to_string(low) + " to " + std::to_string(high));
    return value;
}

std::optional<Budget> query_budget(const Request& request) {
    const auto vertices = query_integer(request, "vertices", 1, UINT32_MAX);
    const auto bytes = query_integer(request, "bytes", 1, UINT64_MAX);
    const auto distortion = query_positive(request, "distortion");
    if (vertices.has_value() + bytes.has_value() + distortion.has_value() > 1)
        throw HttpProblem(400, "a budget is one of vertices=, bytes= and distortion=, not two of them");
    if (vertices) return VertexBudget{static_cast<std::uint32_t>(*vertices)};
    if (bytes) return ByteBudget{*bytes};
    if (distortion) return DistortionBudget{*distortion};
    return std::nullopt;
}

}  // namespace anyrate
