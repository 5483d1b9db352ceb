#pragma once
#include <memory>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/point_grid.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// The parts of a closed surface that no image shows, such as the floor that closes a narrow-necked pot where no view
/// looks. What the photographs have there is the surface behind, so a guess must not follow them, nor be refined by
/// them; it stays where it is.
class GuessedSurface {
public:
    /// Nothing is a guess.
    GuessedSurface() = default;

    /// @param points  of the guessed parts, as dense as `reach` at least
    /// @param reach   of a point, world units
    GuessedSurface(std::vector<OrientedPoint> points, double reach);

    /// @return one flag a vertex: 1 if a point of a guessed part that faces the same way is near
    std::vector<char> vertices(const SurfaceView& surface) const;

    std::span<const OrientedPoint> points() const { return points_; }
    double reach() const { return reach_; }

private:
    std::vector<OrientedPoint> points_;
    double reach_ = 0;
    std::unique_ptr<PointGrid> grid_;  ///< of points_, whose buffer stays where it is when this is moved
};

/// Of a mesh: the flagged vertices and the middles of the edges between them, each with a reach of half an edge: what
/// is on the guess after the mesh was subdivided or simplified is near a point of it, what is beside it is not.
/// @param is_guessed  one flag a vertex
GuessedSurface guessed_part(const Mesh& mesh, std::span<const char> is_guessed);

struct EvidenceOptions {
    double reach = 0;         ///< of a silhouette point, world units
    double tolerance_px = 3;  ///< of disparity, within which a depth map shows a point
    int n_views = 1;          ///< that must show it
};

/// The points of the visual hull, without those that views see through.
struct SilhouettePoints {
    std::span<const OrientedPoint> all;
    std::span<const OrientedPoint> seen;  ///< those that enough views look at
};

/// The vertices of `surface` that neither a silhouette nor the depth maps show.
/// @param unseen  one flag a vertex: 1 where only the seen points count, see unseen_vertices()
std::vector<OrientedPoint> guessed_points(const SurfaceView& surface, std::span<const char> unseen,
                                          const SilhouettePoints& silhouette, std::span<const DepthMap> maps,
                                          const EvidenceOptions& options);

}  // namespace anyrate
