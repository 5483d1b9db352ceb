#pragma once
#include <map>
#include <string>

namespace CLI {
class Validator;
}

namespace anyrate {

/// Accepts one of some names, which then stands for what the option is set from; anything else is wrong usage.
CLI::Validator one_of_names(const std::map<std::string, std::string>& meanings);

/// The names of an enumeration's values, and nothing else: its numbers are wrong usage.
template <class Enum>
CLI::Validator one_of(const std::map<std::string, Enum>& values) {
    std::map<std::string, std::string> meanings;  // the library reads enumerations as numbers
    for (const auto& [name, value] : values) meanings[name] = std::to_string(static_cast<int>(value));
    return one_of_names(meanings);
}

}  // namespace anyrate
