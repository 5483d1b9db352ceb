#pragma once
#include "core/capture/capture.h"
#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// A capture's own frame: its cameras stand around the origin, at a distance of one in the mean.
struct CaptureFrame {
    Vec3 origin = Vec3::Zero();  ///< of this frame, world units
    double unit = 1;             ///< world units per unit of this frame

    /// A grid of this frame as the world sees it: the same integers stand for the same places.
    Grid in_world(const Grid& grid) const;
};

/// Moves the cameras into the capture's own frame. Their centres are rounded there, to 1.5e-8 of the mean distance
/// (some 1e-5 pixels), so that captures which differ in nothing but the world's unit and origin become equal, bit by
/// bit, and so does whatever is computed from them: a choice that hangs on the last bit, and with it the mesh, would
/// else depend on the unit.
CaptureFrame to_own_frame(Capture& capture);

}  // namespace anyrate
