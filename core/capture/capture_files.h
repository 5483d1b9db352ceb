#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/capture/zip_archive.h"

namespace anyrate {

/// The files of a capture, by relative_name(), wherever they lie. Safe to use from several threads.
class CaptureFiles {
public:
    virtual ~CaptureFiles() = default;

    /// Size in bytes; nullopt if there is no such regular file.
    virtual std::optional<std::uint64_t> size(const std::string& name) const = 0;

    /// The first `at_most` bytes of a file that is there.
    /// @throws IoError if it cannot be read
    virtual std::vector<std::uint8_t> read(const std::string& name,
                                           std::size_t at_most = std::numeric_limits<std::size_t>::max()) const = 0;
};

/// The folder of a zip that the capture lies in, the one that has `cameras_file` in it: "" for the top, or "folder/".
/// @param names  of the zip's files @throws InputError there are two
std::string top_folder(const std::vector<std::string>& names, const std::string& zip_name,
                       const std::string& cameras_file);

/// Opens the folder or zip file at `path`. In a zip the whole capture may also lie in one top folder, the one that has
/// `cameras_file` in it. Links in a folder are followed (the folder is its owner's); links in a zip are refused.
/// @throws InputError nothing is there, or read_zip() refuses it
/// @throws IoError    the machine could not read it
std::unique_ptr<CaptureFiles> open_capture_files(const std::filesystem::path& path, const std::string& cameras_file,
                                                 const ZipLimits& limits = {});

}  // namespace anyrate
