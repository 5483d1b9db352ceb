#pragma once
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/progressive/refinable_mesh.h"
#include "core/reconstruction/exposure.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {

/// What step 3 works with besides the capture and the decoded state: what steps 1 and 2 found out. Lengths are in the
/// capture's own frame (to_own_frame()).
struct RefinementStart {
    Grid grid;
    BaseMesh base;                            ///< as the sink's start() was given it
    std::vector<Gains> gains;                 ///< that the colours were divided by, one a view; empty for none
    std::vector<std::vector<Vec2>> shifts;    ///< one a view, pixels of the photographs, for each time views were moved
    double mask_growth_px = 0;                ///< see Silhouettes::grow_masks()
    std::vector<OrientedPoint> guess_points;  ///< of the GuessedSurface
    double guess_reach = 0;                   ///< of such a point
    Mesh fitted;                              ///< the surface that base and splits approach
};

/// Where step 3 stood after the base, or after a batch.
struct RefinementPoint {
    RefinableMesh state;            ///< as decoded from the log; its grid may stand in the world
    std::vector<char> is_rejected;  ///< see refine()
};

/// Keeps what a reconstruction knows besides its log, so that a process that died can be followed by one that goes on
/// where the log ends (resume()).
class RefinementJournal {
public:
    virtual ~RefinementJournal() = default;
    /// Before the sink's start().
    virtual void begin(const RefinementStart& start) = 0;
    /// After the sink has the base's attributes, and after each batch. @param is_rejected  see refine()
    virtual void batch(std::span<const char> is_rejected) = 0;
};

}  // namespace anyrate
