#pragma once
#include "core/mesh/mesh.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/reconstruct.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct InitialSurface {
    Mesh mesh;               ///< fine, still to be remeshed to the coarse count; world units
    GuessedSurface guessed;  ///< its parts that no image shows
};

/// The hull to begin with: its cells are as wide as the pixels that are swept, so that the surface is neither too
/// coarse for what depths tell of a thin wall nor so fine that their noise pierces it. With cells of two pixels always,
/// a bowl had a hole through its bottom from photographs 320 pixels wide, and nine tunnels from 1,280.
HullOptions hull_options(const PhotoImages& images);

/// Step 1 of the method behind the visual hull: its lids over cavities opened by a plane sweep, Poisson, iso-surface,
/// largest piece without tiny handles. `progress` hears of the stages hull (its second half) and poisson.
/// @param images  of the capture whose hull it is
InitialSurface initial_surface(const VisualHull& hull, const PhotoImages& images, const ProgressFn& progress);

}  // namespace anyrate
