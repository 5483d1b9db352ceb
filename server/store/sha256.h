#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace anyrate {

using Sha256 = std::array<unsigned char, 32>;

Sha256 sha256(std::span<const std::byte> bytes);
/// Of a file's bytes. @throws IoError
Sha256 sha256_of_file(const std::filesystem::path& file);

std::string to_hex(const Sha256& digest);
std::string to_base64(const Sha256& digest);
/// Whether two digests are equal, in a time that does not depend on where they differ.
bool equal_in_constant_time(const Sha256& a, const Sha256& b);

}  // namespace anyrate
