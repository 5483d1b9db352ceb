#pragma once
#include <optional>
#include <vector>

#include "core/capture/camera.h"
#include "core/capture/cameras_json.h"
#include "core/capture/faults.h"

namespace anyrate {

/// The camera of an entry under the conventions of Camera: principal point moved by `pixel_center`, K scaled to
/// K(2,2) = 1, R the nearest rotation to a nearly orthogonal matrix (a file may hold six digits). Its size is left 0.
/// @return nullopt if the entry has no camera, or not one that could have taken a photograph: one fault for each reason
std::optional<Camera> to_camera(const CameraEntry& entry, const Vec2& pixel_center, Faults& faults);

/// Adds a fault if all the cameras stand at one place: then nothing is known about depth.
void check_baseline(const std::vector<Camera>& cameras, const std::string& cameras_file, Faults& faults);

}  // namespace anyrate
