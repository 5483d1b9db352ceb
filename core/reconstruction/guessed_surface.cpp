#include "core/reconstruction/guessed_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

bool is_near(const PointGrid& grid, const OrientedPoint& point) {
    bool near = false;
    grid.for_each_near(point, [&](const OrientedPoint&) { return near = true, false; });
    return near;
}

Vec3 centre_of(const Mat34& P) { return -P.leftCols<3>().inverse() * P.col(3); }

bool shows(const DepthMap& map, const Vec3& centre, const OrientedPoint& point, double tolerance_px) {
    if (!(point.normal.dot(centre - point.position) > 0)) return false;
    const Vec3 x = map.P * point.position.homogeneous();
    if (!(x.z() > 0)) return false;
    const double u = x.x() / x.z() + 0.5, v = x.y() / x.z() + 0.5;
    const auto& known = map.inverse_depth;
    if (!(u >= 0 && v >= 0 && u < known.width && v < known.height)) return false;
    const double surface = known(static_cast<int>(u), static_cast<int>(v));
    return surface > 0 && std::abs(surface - 1.0 / x.z()) <= tolerance_px * map.step;
}

}  // namespace

GuessedSurface::GuessedSurface(std::vector<OrientedPoint> points, double reach)
    : points_(std::move(points)), reach_(reach) {
    if (!points_.empty()) grid_ = std::make_unique<PointGrid>(points_, reach);
}

std::vector<char> GuessedSurface::vertices(const SurfaceView& surface) const {
    std::vector<char> guessed(surface.vertices.size(), 0);
    if (points_.empty()) return guessed;
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    parallel_for(guessed.size(), [&](std::size_t v) {
        guessed[v] = is_near(*grid_, {surface.vertices[v], normals[v], 0.0});
    });
    return guessed;
}

std::vector<OrientedPoint> guessed_points(const SurfaceView& surface, std::span<const char> unseen,
                                          const SilhouettePoints& silhouette, std::span<const DepthMap> maps,
                                          const EvidenceOptions& options) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    const PointGrid all(silhouette.all, options.reach), seen(silhouette.seen, options.reach);
    std::vector<Vec3> centres;
    for (const DepthMap& map : maps) centres.push_back(map.step > 0 ? centre_of(map.P) : Vec3::Zero());
    std::vector<char> guessed(surface.vertices.size());
    parallel_for(guessed.size(), [&](std::size_t v) {
        const OrientedPoint point{surface.vertices[v], normals[v], 0.0};
        if (is_near(unseen[v] != 0 ? seen : all, point)) return;
        int n_views = 0;
        for (std::size_t i = 0; i < maps.size() && n_views < options.n_views; ++i)
            n_views += maps[i].step > 0 && shows(maps[i], centres[i], point, options.tolerance_px);
        guessed[v] = n_views < options.n_views;
    });
    std::vector<OrientedPoint> points;
    for (std::size_t v = 0; v < guessed.size(); ++v)
        if (guessed[v] != 0) points.push_back({surface.vertices[v], normals[v], 0.0});
    return points;
}

GuessedSurface guessed_part(const Mesh& mesh, std::span<const char> is_guessed) {
    const OneRings rings(mesh);
    const std::vector<Vec3> normals = vertex_normals(mesh, rings);
    const std::vector<double> edges = mean_edge_lengths(mesh, rings);
    std::vector<OrientedPoint> points;
    double sum_of_edges = 0;
    for (std::size_t v = 0; v < is_guessed.size(); ++v)
        if (is_guessed[v] != 0) {
            points.push_back({mesh.vertices[v], normals[v], 0.0});
            sum_of_edges += edges[v];
        }
    if (points.empty()) return {};
    const double reach = 0.5 * sum_of_edges / static_cast<double>(points.size());
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v) {
        if (is_guessed[at(v)] == 0) continue;
        for (const std::int32_t w : rings.neighbours(v))
            if (w > v && is_guessed[at(w)] != 0)
                points.push_back({0.5 * (mesh.vertices[at(v)] + mesh.vertices[at(w)]),
                                  (normals[at(v)] + normals[at(w)]).normalized(), 0.0});
    }
    return GuessedSurface(std::move(points), reach);
}

}  // namespace anyrate
