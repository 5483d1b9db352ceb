#include "core/reconstruction/unseen_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>

#include "core/mesh/disjoint_sets.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

bool contains(const PhotoLevel& image, const Vec3& position) {
    const Vec3 x = image.P * position.homogeneous();
    return x.z() > 0 && x.x() >= 0 && x.y() >= 0 && x.x() <= image.width * x.z() && x.y() <= image.height * x.z();
}

bool is_unseen(const Vec3& position, const Vec3& normal, const PhotoImages& images, const UnseenOptions& options) {
    const auto looks = [&](const PhotoView& view) {
        const Vec3 way = view.centre - position;
        return way.dot(normal) > options.least_cos * way.norm() && contains(view.levels.front(), position);
    };
    return std::ranges::count_if(images.views, looks) < options.n_views;
}

/// Takes the flags off the connected parts that have less than a share of the surface's area.
void drop_small_parts(const SurfaceView& surface, std::vector<char>& flags, double least_share) {
    DisjointSets parts(flags.size());
    for (const Triangle& t : surface.triangles)
        for (const auto& [a, b] : {std::pair(t[0], t[1]), std::pair(t[1], t[2]), std::pair(t[2], t[0])})
            if (flags[at(a)] != 0 && flags[at(b)] != 0) parts.unite(a, b);
    std::vector<double> areas(flags.size());  // thrice each part's, where its name is
    double whole = 0;
    for (const Triangle& t : surface.triangles) {
        const Vec3& a = surface.vertices[at(t[0])];
        const double area = 0.5 * (surface.vertices[at(t[1])] - a).cross(surface.vertices[at(t[2])] - a).norm();
        whole += area;
        for (const std::int32_t v : t)
            if (flags[at(v)] != 0) areas[at(parts.find(v))] += area;
    }
    for (std::int32_t v = 0; v < surface.n_vertices(); ++v)
        if (flags[at(v)] != 0) flags[at(v)] = areas[at(parts.find(v))] >= 3.0 * least_share * whole;
}

}  // namespace

std::vector<char> unseen_vertices(const SurfaceView& surface, const PhotoImages& images, const UnseenOptions& options) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    std::vector<char> unseen(surface.vertices.size());
    parallel_for(unseen.size(),
                 [&](std::size_t v) { unseen[v] = is_unseen(surface.vertices[v], normals[v], images, options); });
    drop_small_parts(surface, unseen, options.least_share);
    return unseen;
}

std::vector<OrientedPoint> without_unseen(std::span<const OrientedPoint> points, const PhotoImages& images,
                                          const UnseenOptions& options) {
    std::vector<OrientedPoint> seen;
    std::ranges::copy_if(points, std::back_inserter(seen), [&](const OrientedPoint& point) {
        return !is_unseen(point.position, point.normal, images, options);
    });
    return seen;
}

}  // namespace anyrate
