#include "core/reconstruction/mean_curvature.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

double cotangent(const Vec3& a, const Vec3& b) {
    const double area = a.cross(b).norm();
    // A needle's cotangent is unbounded: it would outweigh the whole ring.
    return std::clamp(a.dot(b) / std::max(area, 1e-300), -20.0, 20.0);
}

struct RingSums {
    Vec3 laplacian = Vec3::Zero();
    double area = 0;
};

/// What the face with corners p, q, r adds at p.
void add_face(const Vec3& p, const Vec3& q, const Vec3& r, RingSums& sums) {
    const double cot_q = cotangent(p - q, r - q), cot_r = cotangent(p - r, q - r);
    sums.laplacian += 0.5 * (cot_r * (q - p) + cot_q * (r - p));
    const double area = 0.5 * (q - p).cross(r - p).norm();
    const bool obtuse_at_p = (q - p).dot(r - p) < 0;
    if (obtuse_at_p)
        sums.area += area / 2;
    else if (cot_q < 0 || cot_r < 0)
        sums.area += area / 4;
    else
        sums.area += ((q - p).squaredNorm() * cot_r + (r - p).squaredNorm() * cot_q) / 8;
}

}  // namespace

std::vector<Vec3> mean_curvature_normals(const SurfaceView& surface, const OneRings& rings) {
    std::vector<Vec3> curvature(surface.vertices.size());
    parallel_for(curvature.size(), [&](std::size_t v) {
        RingSums sums;
        for (std::int32_t f : rings.faces(static_cast<std::int32_t>(v))) {
            const Triangle& t = surface.triangles[at(f)];
            const std::size_t k = at(t[0]) == v ? 0 : at(t[1]) == v ? 1 : 2;
            add_face(surface.vertices[v], surface.vertices[at(t[(k + 1) % 3])], surface.vertices[at(t[(k + 2) % 3])],
                     sums);
        }
        // The Laplacian of the position is 2 H n; the integral over the mixed area is the cotangent sum.
        curvature[v] = sums.area > 0 ? Vec3(sums.laplacian / (2 * sums.area)) : Vec3::Zero();
    });
    return curvature;
}

}  // namespace anyrate
