#pragma once
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

#include "proto/index.h"
#include "server/http/message.h"

namespace anyrate {

/// Refuses parameters that the resource does not know, so that a misspelt one is noticed.
/// @throws HttpProblem 400 naming the parameter
void expect_only(const Request& request, std::initializer_list<std::string_view> names);

/// A whole number between `low` and `high`, nullopt if the parameter is absent. @throws HttpProblem 400
std::optional<std::uint64_t> query_integer(const Request& request, const char* name, std::uint64_t low,
                                           std::uint64_t high);

/// The budget of `vertices=`, `bytes=` or `distortion=`; nullopt if none is there.
/// @throws HttpProblem 400 for a bad value, or two of them
std::optional<Budget> query_budget(const Request& request);

}  // namespace anyrate
