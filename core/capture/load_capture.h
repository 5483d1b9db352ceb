#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/capture/capture.h"

namespace anyrate {

struct LoadOptions {
    std::string cameras_file = "cameras.json";  ///< name inside the capture
    std::int64_t max_pixels = 50'000'000;        ///< of one image; read from the file's header before any pixel is decoded
};

/// Reads a capture from a folder or a zip file (`images/*`, `masks/*` or an alpha channel, `cameras.json`; see README).
/// Every promise of Camera, View and Capture holds for the result.
/// @throws InputError one sentence per fault, one fault a line: file, what was found, what was expected
/// @throws IoError    the machine could not read a file that is there
Capture load_capture(const std::filesystem::path& folder_or_zip, const LoadOptions& options = {});

/// Writes `images/NNN.png`, `masks/NNN.png` and `cameras.json` (pixel_center 0.5) into `folder`, making it if need be.
/// @throws IoError a file could not be written
void save_capture(const Capture& capture, const std::filesystem::path& folder);

}  // namespace anyrate
