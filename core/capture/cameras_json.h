#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/capture/capture.h"
#include "core/capture/faults.h"
#include "core/capture/undistort.h"

namespace anyrate {

/// Of a list of cameras, about 13,000 entries; a parsed one takes some twenty times its size.
inline constexpr std::uint64_t max_cameras_bytes = 8 << 20;

/// One photograph as cameras.json lists it; what its numbers mean is not yet checked (see check_camera.h).
struct CameraEntry {
    bool is_well_formed = true;        ///< false if any field was a fault; that field then has its default
    std::string file;                  ///< the image's relative_name()
    std::string mask;                  ///< the mask's relative_name(); empty if none is given
    std::optional<int> width, height;  ///< pixels; nullopt if not given
    std::optional<Mat3> K, R;          ///< finite; nullopt if malformed
    std::optional<Vec3> t;
    Distortion distortion;
};

struct CameraList {
    /// Where the file puts the centre of the top-left pixel. A file that does not say means (0.5, 0.5), as
    /// save_capture() and most renderers write.
    Vec2 pixel_center{0.5, 0.5};
    std::vector<CameraEntry> entries;
};

/// Parses
///   {"pixel_center": [c, c],
///    "images": [{"file": "images/000.png", "mask": "masks/000.png", "width": 640, "height": 480,
///                "K": 3 rows of 3, "R": 3 rows of 3, "t": 3 numbers, "distortion": [k1, k2, p1, p2, k3]}, ...]}.
/// The list may also be called "cameras", "views" or "frames". Required are file, K, R and t; k3 may be left out.
/// Fields it does not know are ignored.
/// @param name    of the JSON file, for messages
/// @param faults  takes one sentence for every field that is malformed
/// @throws InputError if it is not JSON, with line and column, or there is no list
CameraList parse_cameras(std::string_view json, const std::string& name, Faults& faults);

/// The JSON text for views whose images and masks are called like `files[i]` and `masks[i]`, pixel_center (0.5, 0.5).
std::string format_cameras(const std::vector<View>& views, const std::vector<std::string>& files,
                           const std::vector<std::string>& masks);

}  // namespace anyrate
