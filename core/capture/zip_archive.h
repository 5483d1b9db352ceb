#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace anyrate {

/// How much a zip file may unpack to. A zip that promises or delivers more is refused as soon as it shows.
struct ZipLimits {
    std::int64_t max_files = 20'000;
    std::int64_t max_bytes = std::int64_t{1} << 30;  ///< of all files together, unpacked
    std::int64_t max_ratio = 100;                    ///< unpacked bytes a packed byte, once 16 MiB are unpacked
};

/// The regular files of a zip, by relative_name().
using ZipContents = std::map<std::string, std::vector<std::uint8_t>>;

/// Takes a file of a zip.
using TakeZipFile = std::function<void(const std::string& name, std::vector<std::uint8_t> data)>;
/// Whether a file of a zip is to be unpacked.
using WantZipFile = std::function<bool(const std::string& name)>;

/// Unpacks a zip file by file, so that only one is in memory at a time; nothing is written anywhere.
/// @param name    of the zip, for messages
/// @param wanted  asked for each file; empty for all. What is not wanted is passed over, and refused for its name
/// alone.
/// @throws what read_zip() throws
void visit_zip(const std::filesystem::path& file, const std::string& name, const ZipLimits& limits,
               const TakeZipFile& take, const WantZipFile& wanted = {});

/// Unpacks a zip into memory; nothing is written anywhere.
/// @throws InputError if it is no zip or a damaged or encrypted one, goes beyond a limit, or holds what a capture never
///                    needs and an attack might: links, names that lead out of the folder, one name twice
/// @throws IoError    the machine could not read the file
ZipContents read_zip(const std::filesystem::path& file, const ZipLimits& limits = {});

/// The same from memory; `name` is for messages.
ZipContents read_zip(std::span<const std::uint8_t> bytes, const std::string& name, const ZipLimits& limits = {});

}  // namespace anyrate
