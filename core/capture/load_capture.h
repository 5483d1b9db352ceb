#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/capture/capture.h"
#include "core/capture/zip_archive.h"

namespace anyrate {

struct LoadOptions {
    std::string cameras_file = "cameras.json";  ///< name inside the capture; only the images it lists are read
    std::int64_t max_pixels = 50'000'000;  ///< of one image; read from the file's header before any pixel is decoded
    /// Bytes of one image: 16 bits in four channels and some text around them.
    std::uint64_t max_image_bytes() const { return 8 * static_cast<std::uint64_t>(max_pixels) + (1 << 20); }
    std::int64_t max_capture_pixels = 2'000'000'000;  ///< of all images together, before any pixel is decoded
    /// What is kept of them: images that have more together are halved in width and height, until they have not. A
    /// kept pixel costs a reconstruction about ten bytes.
    std::int64_t max_kept_pixels = 300'000'000;
    ZipLimits zip = {};
};

/// Reads a capture from a folder or a zip file: `images/*`, `masks/*`, `cameras.json` (its fields: parse_cameras()).
/// Every promise of Camera, View and Capture holds for the result; masks are 0 and 255.
///
/// Images and masks are PNG or JPEG of any depth. The mask of an image is, the first that there is: the file named in
/// its entry, the file of the same name in `masks/` (or of that name with .png), its own alpha channel. A
/// `pixel_center` that is not given is (0.5, 0.5). Images with `distortion` are undistorted, their K stays. Images that
/// are too large together are halved one by one as they are read.
/// @throws InputError one sentence per fault, one fault a line: file, what was found, what was expected
/// @throws IoError    the machine could not read a file that is there
Capture load_capture(const std::filesystem::path& folder_or_zip, const LoadOptions& options = {});

/// Writes `images/NNN.png`, `masks/NNN.png` and `cameras.json` (pixel_center 0.5) into `folder`, making it if need be.
/// Files of those names are replaced; the views' names are not kept.
/// @throws IoError a file could not be written
void save_capture(const Capture& capture, const std::filesystem::path& folder);

}  // namespace anyrate
