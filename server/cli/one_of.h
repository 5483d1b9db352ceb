#pragma once
#include <map>
#include <string>

namespace CLI {
class Validator;
}

namespace anyrate {

/// Accepts one of some names, which then stands for what the option is set from; anything else is wrong usage.
CLI::Validator one_of(const std::map<std::string, std::string>& meanings);

/// What an enumeration's names stand for: the library reads its values as numbers.
template <class Enum>
std::map<std::string, std::string> numbers_of(const std::map<std::string, Enum>& values) {
    std::map<std::string, std::string> numbers;
    for (const auto& [name, value] : values) numbers[name] = std::to_string(static_cast<int>(value));
    return numbers;
}

}  // namespace anyrate
