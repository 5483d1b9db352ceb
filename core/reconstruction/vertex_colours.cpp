#include "core/reconstruction/vertex_colours.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/mesh/triangle_shape.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

using Colour = Eigen::Vector3d;

/// How wide a part of a photograph makes a colour, in parts of the distance to the next vertex. At 10,000 vertices of
/// four captures 0.5 lowers the root mean square difference between the painted mesh and the photographs by 1 to 3 %,
/// beside single points, and the colours' bytes by 4 to 9 %; 1 lowers them by 12 to 22 %, but adds 4 to 14 % to the
/// mean difference of the synthetic ones.
constexpr double width_in_spacings = 0.5;

/// Mean colour of the photograph around the image of a point.
/// @param width_px  of the part of the photograph that counts, pixels of level 0
std::optional<Colour> blurred_colour(const PhotoView& view, const Vec3& p, double width_px) {
    const double level = std::clamp(std::log2(std::max(width_px, 1.0)), 0.0, view.levels.size() - 1.0);
    const auto at_level = [&](std::size_t l) -> std::optional<Colour> {
        const PhotoLevel& image = view.levels[l];
        const Vec3 x = image.P * p.homogeneous();
        ColourSample c;
        if (!sample_colour(image, x.x() / x.z(), x.y() / x.z(), c)) return std::nullopt;
        return Colour(c.c[0], c.c[1], c.c[2]);
    };
    const auto finer = static_cast<std::size_t>(level);
    const std::optional<Colour> fine = at_level(finer);
    if (!fine) return finer > 0 ? blurred_colour(view, p, 0.5 * width_px) : std::nullopt;  // near the silhouette
    const double part = level - static_cast<double>(finer);
    if (part == 0) return fine;
    const std::optional<Colour> coarse = at_level(finer + 1);
    return coarse ? Colour((1 - part) * *fine + part * *coarse) : fine;
}

std::optional<Colour> seen_colour(const PhotoImages& images, const Visibility& visibility, const SurfaceView& surface,
                                  const OneRings& rings, const Vec3& normal, double spacing, std::int32_t v) {
    Colour sum = Colour::Zero();
    double weight = 0;
    for (std::int32_t i = 0; i < images.n_views(); ++i) {
        const PhotoView& view = images.views[at(i)];
        const Vec3& p = surface.vertices[at(v)];
        const double cos_theta = normal.dot((view.centre - p).normalized());
        if (cos_theta <= 0.1) continue;
        const auto ring = rings.faces(v);
        const auto sees = [&](std::int32_t f) {
            const auto views = visibility.views(f);
            return std::any_of(views.begin(), views.end(),
                               [i](const FaceView& fv) { return fv.view == i && fv.whole; });
        };
        if (std::none_of(ring.begin(), ring.end(), sees)) continue;
        const double width_px = width_in_spacings * spacing * cos_theta * view.focal_px / (view.centre - p).norm();
        const std::optional<Colour> c = blurred_colour(view, p, width_px);
        if (!c) continue;
        sum += cos_theta * *c;
        weight += cos_theta;
    }
    if (weight == 0) return std::nullopt;
    return sum / weight;
}

/// Spreads colours over the edges into what no view sees, one ring at a time.
void spread(const OneRings& rings, std::vector<std::optional<Colour>>& colours) {
    std::vector<std::int32_t> empty;
    for (std::size_t v = 0; v < colours.size(); ++v)
        if (!colours[v]) empty.push_back(static_cast<std::int32_t>(v));
    while (!empty.empty()) {
        std::vector<std::pair<std::int32_t, Colour>> filled;
        for (std::int32_t v : empty) {
            Colour sum = Colour::Zero();
            int n = 0;
            for (std::int32_t w : rings.neighbours(v))
                if (colours[at(w)]) {
                    sum += *colours[at(w)];
                    ++n;
                }
            if (n > 0) filled.emplace_back(v, sum / n);
        }
        if (filled.empty()) break;
        for (const auto& [v, c] : filled) colours[at(v)] = c;
        std::erase_if(empty, [&](std::int32_t v) { return colours[at(v)].has_value(); });
    }
}

Rgb8 to_rgb8(const Colour& c) {
    const auto channel = [](double x) { return static_cast<std::uint8_t>(std::clamp(x + 0.5, 0.0, 255.0)); };
    return {channel(c[0]), channel(c[1]), channel(c[2])};
}

}  // namespace

double vertex_spacing(const SurfaceView& surface, int n_vertices) {
    double area = 0;
    for (const auto& [a, b, c] : surface.triangles)
        area +=
            0.5 * twice_area_vector(surface.vertices[at(a)], surface.vertices[at(b)], surface.vertices[at(c)]).norm();
    // A vertex of a plane of equilateral triangles has sqrt(3) / 2 squared edges for itself.
    return std::sqrt(area / n_vertices * 2 / std::sqrt(3.0));
}

std::vector<Rgb8> vertex_colours(const PhotoImages& images, const SurfaceView& surface, double spacing,
                                 std::span<const std::int32_t> vertices, const Visibility* visibility) {
    const OneRings rings(surface);
    const std::vector<Vec3> normals = vertex_normals(surface, rings);
    std::optional<Visibility> own;
    if (visibility == nullptr) visibility = &own.emplace(images, surface);
    std::vector<double> spacings = mean_edge_lengths(surface, rings);
    for (double& x : spacings) x = std::min(x, spacing);
    std::vector<std::optional<Colour>> colours(surface.vertices.size());
    std::vector<std::int32_t> all(colours.size());
    std::iota(all.begin(), all.end(), 0);
    if (vertices.empty()) vertices = all;
    const auto look_at = [&](std::span<const std::int32_t> some) {
        parallel_for(some.size(), [&](std::size_t i) {
            const std::int32_t v = some[i];
            colours[at(v)] = seen_colour(images, *visibility, surface, rings, normals[at(v)], spacings[at(v)], v);
        });
    };
    look_at(vertices);
    // Only what no view sees needs the colours of the others.
    if (std::ranges::any_of(vertices, [&](std::int32_t v) { return !colours[at(v)]; })) {
        look_at(all);
        spread(rings, colours);
    }

    std::vector<Rgb8> result;
    result.reserve(vertices.size());
    for (std::int32_t v : vertices) result.push_back(to_rgb8(colours[at(v)].value_or(Colour(128, 128, 128))));
    return result;
}

}  // namespace anyrate
