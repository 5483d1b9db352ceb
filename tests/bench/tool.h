#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>

namespace anyrate::bench {

using Json = nlohmann::ordered_json;

/// What every tool of this folder does around its work: parses the command line, prints the object that `work` returns
/// to standard output, or why there is none to standard error. @return the exit code: 0, 1 failed, 2 wrong usage, 3 bad
/// input, as `anyrate` has them
int run_tool(CLI::App& app, int argc, char** argv, const std::function<Json()>& work);

}  // namespace anyrate::bench
