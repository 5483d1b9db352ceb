#pragma once
#include <filesystem>

namespace CLI {
class App;
}

namespace anyrate {

/// Gives the options of a command the values of a file of lines like `workers=2`, named as the flags without dashes;
/// an option that has a value already, from a flag or the environment, keeps it. CLI11 reads such a file for the
/// outermost command only.
/// @throws CLI::ParseError (wrong usage) the file cannot be read, names what is no option, or has a bad value
void read_config_file(CLI::App& command, const std::filesystem::path& file);

}  // namespace anyrate
