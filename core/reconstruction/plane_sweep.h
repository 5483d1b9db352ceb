#pragma once
#include <vector>

#include "core/capture/image.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

struct SweepOptions {
    int most_object_px = 40'000;  ///< that a view shows on average; decides the level of the pyramid
    int window_radius_px = 1;     ///< the window compared has 2 r + 1 pixels a side
    int n_neighbours = 4;         ///< views that one view is compared with, at most (16 at most); six find no more
                                  ///< (pot, 36 views: 2.6 s of the hull's stage instead of 3.1)
    double min_angle_deg = 8.0;   ///< between two viewing directions: below, depth is a guess
    double max_angle_deg = 45.0;  ///< above, the same surface no longer looks the same
};

/// The level of the pyramid that is swept: the finest at which the views show no more of the object than they may.
int swept_level(const PhotoImages& images, const SweepOptions& options = {});

/// How far away the object is at every pixel of one view.
struct DepthMap {
    Mat34 P = Mat34::Zero();     ///< to the pixels of the images below, which show no more than the object
    double step = 0;             ///< of inverse depth, that is one pixel of disparity in the widest neighbour
    Image<float> inverse_depth;  ///< along the optical axis, 1 / world units; 0 where nothing is known
    Image<float> agreement;      ///< of the images there, 0 to 1: the mean squared correlation of the windows
};

/// Sweeps planes parallel to the image through the visual hull, view by view: each plane carries the neighbouring views
/// into this one, where windows are compared by normalised cross-correlation and the better half of the neighbours
/// counts (the others may not see the point). Semi-global matching chooses among the planes: of all that meet the hull
/// at half the resolution, then of those near what was chosen there. Source: Collins 1996, "A space-sweep approach to
/// true multi-image matching"; correlation over windows with best-half selection as in Kang, Szeliski, Chai 2001,
/// "Handling occlusions in dense multi-view stereo".
/// @return one map a view; a view without neighbours at a fitting angle has an empty one
std::vector<DepthMap> plane_sweep(const PhotoImages& images, const VisualHull& hull, const SweepOptions& options = {});

}  // namespace anyrate
