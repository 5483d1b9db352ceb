#include "core/reconstruction/vertex_colours.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "core/reconstruction/visibility.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

using Colour = Eigen::Vector3d;

std::optional<Colour> seen_colour(const PhotoImages& images, const Visibility& visibility, const SurfaceView& surface,
                                  const OneRings& rings, const Vec3& normal, std::int32_t v) {
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
        const Vec3 x = view.levels.front().P * p.homogeneous();
        ColourSample c;
        if (!sample_colour(view.levels.front(), x.x() / x.z(), x.y() / x.z(), c)) continue;
        sum += cos_theta * Colour(c.c[0], c.c[1], c.c[2]);
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

std::vector<Rgb8> vertex_colours(const PhotoImages& images, const SurfaceView& surface,
                                 std::span<const std::int32_t> vertices) {
    const OneRings rings(surface);
    const std::vector<Vec3> normals = vertex_normals(surface, rings);
    const Visibility visibility(images, surface);
    std::vector<std::optional<Colour>> colours(surface.vertices.size());
    std::vector<std::int32_t> all(colours.size());
    std::iota(all.begin(), all.end(), 0);
    if (vertices.empty()) vertices = all;
    const auto look_at = [&](std::span<const std::int32_t> some) {
        parallel_for(some.size(), [&](std::size_t i) {
            const std::int32_t v = some[i];
            colours[at(v)] = seen_colour(images, visibility, surface, rings, normals[at(v)], v);
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
