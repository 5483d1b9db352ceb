#include "server/cli/one_of.h"

#include <CLI/CLI.hpp>

namespace anyrate {

CLI::Validator one_of(const std::map<std::string, std::string>& meanings) {
    std::string names;
    for (const auto& [name, meaning] : meanings) names += (names.empty() ? "" : "|") + name;
    const auto by_name = [meanings, names](std::string& text) -> std::string {
        const auto found = meanings.find(text);
        if (found == meanings.end()) return "expected " + names + ", got " + text;
        text = found->second;
        return {};
    };
    return CLI::Validator(by_name, names, "one of");
}

}  // namespace anyrate
