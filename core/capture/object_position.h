#pragma once
#include <span>
#include <string>

#include "core/capture/capture.h"
#include "core/capture/faults.h"

namespace anyrate {

/// Adds a fault for every view whose camera has the object behind it, or whose mask shows it where the other views say
/// it is not: a sign of t turned over, a camera-to-world pose, y up. Calibrations as rough as half an object pass.
///
/// The object's place is where most of the masks' bounding boxes agree. Whether a place projects into a box is asked
/// regardless of the sign of its depth, so a world turned inside out is found as a place, and then as one that is
/// behind.
/// @param views         at least three, not all from one place; neither is an empty or a full mask among them
/// @param cameras_file  for messages about all the views together
void check_object_position(std::span<const View* const> views, const std::string& cameras_file, Faults& faults);

}  // namespace anyrate
