#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/capture/capture.h"

namespace anyrate {

constexpr int thumbnail_side =
    216;  ///< pixels of the longer one: what the viewer shows, on a screen of three pixels for one

/// The name of a view's thumbnail in their file.
std::string thumbnail_name(std::size_t view);

/// Writes a JPEG of thumbnail_side for each photograph into one zip; leaves a file that is there.
/// @param epoch  of the lease, so that no other worker writes the same unfinished file
/// @throws IoError
void write_thumbnails(const Capture& capture, const std::filesystem::path& zip, std::uint64_t epoch);

}  // namespace anyrate
