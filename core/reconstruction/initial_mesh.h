#pragma once
#include "core/capture/capture.h"
#include "core/mesh/mesh.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/reconstruct.h"

namespace anyrate {

/// Step 1 of the method: visual hull, its lids over cavities opened by a plane sweep, Poisson, iso-surface, largest
/// piece without tiny handles. World units; a fine mesh still to be remeshed to the coarse count. `progress` hears of
/// the stages hull and poisson.
/// @param images  of the same capture
Mesh initial_surface(const Capture& capture, const PhotoImages& images, const ProgressFn& progress);

}  // namespace anyrate
