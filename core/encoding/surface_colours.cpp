#include "core/encoding/surface_colours.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/mesh/closest_point.h"
#include "core/parallel.h"

namespace anyrate {

std::vector<Rgb8> surface_colours(const Mesh& mesh, const NearestSurface& nearest, std::span<const Vec3> points) {
    if (mesh.colours.empty()) return {};
    std::vector<Rgb8> colours(points.size());
    parallel_for(points.size(), [&](std::size_t i) {
        const NearestSurface::Hit hit = nearest.nearest(points[i]);
        const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(hit.face)];
        const auto vertex = [&](std::int32_t v) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(v)]; };
        const Vec3 weights = barycentric(hit.point, vertex(a), vertex(b), vertex(c));
        Vec3 sum = Vec3::Zero();
        for (Eigen::Index k = 0; const std::int32_t v : {a, b, c}) {
            const Rgb8& colour = mesh.colours[static_cast<std::size_t>(v)];
            sum += weights[k++] * Vec3(colour.r, colour.g, colour.b);
        }
        const auto channel = [](double x) { return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0))); };
        colours[i] = {channel(sum.x()), channel(sum.y()), channel(sum.z())};
    });
    return colours;
}

}  // namespace anyrate
