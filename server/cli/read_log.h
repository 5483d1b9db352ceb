#pragma once
#include <cstddef>
#include <filesystem>
#include <vector>

namespace anyrate {

/// The bytes of the log a user named. @throws InputError if there is no such file, IoError if it cannot be read
std::vector<std::byte> read_log(const std::filesystem::path& file);

}  // namespace anyrate
