#pragma once
#include <cstdint>
#include <functional>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Distances between two surfaces in parts of the reference's bounding-box diagonal.
struct SurfaceDistance {
    double accuracy = 0;      ///< mean, points of the mesh to the reference
    double completeness = 0;  ///< mean, points of the reference to the mesh
    double mean = 0;          ///< of the two
    double p90 = 0;           ///< 90th percentile, both ways pooled with equal weight
    double hausdorff = 0;     ///< largest, both ways
};

struct CompareOptions {
    int n_samples = 100'000;  ///< points drawn on each surface, uniformly by area
    std::uint64_t seed = 1;
};

/// Exact point-to-triangle distances of random surface points, both ways; the same for any number of threads.
/// @throws InputError if a surface has no area
SurfaceDistance compare_surfaces(const Mesh& mesh, const Mesh& reference, const CompareOptions& options = {});

/// The same for the part of the reference that is seen, for instance by two cameras: its other points are left out, and
/// so are those of the mesh whose nearest point of the reference is not seen.
/// @param seen  asked about points of the reference, from several threads at once
/// @throws InputError also if no point is seen
SurfaceDistance compare_surfaces(const Mesh& mesh, const Mesh& reference, const std::function<bool(const Vec3&)>& seen,
                                 const CompareOptions& options = {});

}  // namespace anyrate
