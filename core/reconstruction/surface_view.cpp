#include "core/reconstruction/surface_view.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

OneRings::OneRings(const SurfaceView& surface) {
    const std::size_t n = surface.vertices.size();
    face_begin_.assign(n + 1, 0);
    for (const Triangle& t : surface.triangles)
        for (std::int32_t v : t) ++face_begin_[at(v) + 1];
    for (std::size_t v = 0; v < n; ++v) face_begin_[v + 1] += face_begin_[v];
    faces_.resize(3 * surface.triangles.size());
    std::vector<std::int32_t> fill(face_begin_.begin(), face_begin_.end() - 1);
    for (std::size_t f = 0; f < surface.triangles.size(); ++f)
        for (std::int32_t v : surface.triangles[f]) faces_[at(fill[at(v)]++)] = static_cast<std::int32_t>(f);

    // Each face of a vertex names two neighbours, and another face names most of them again.
    std::vector<std::int32_t> named(2 * faces_.size());
    neighbour_begin_.assign(n + 1, 0);
    parallel_for(
        n,
        [&](std::size_t v) {
            std::int32_t* const first = named.data() + 2 * face_begin_[v];
            std::int32_t* end = first;
            for (std::int32_t f : faces(static_cast<std::int32_t>(v)))
                for (std::int32_t w : surface.triangles[at(f)])
                    if (at(w) != v) *end++ = w;
            std::sort(first, end);
            neighbour_begin_[v + 1] = static_cast<std::int32_t>(std::unique(first, end) - first);
        },
        1024);
    for (std::size_t v = 0; v < n; ++v) neighbour_begin_[v + 1] += neighbour_begin_[v];
    neighbours_.resize(at(neighbour_begin_[n]));
    for (std::size_t v = 0; v < n; ++v)
        std::copy_n(named.data() + 2 * face_begin_[v], neighbour_begin_[v + 1] - neighbour_begin_[v],
                    neighbours_.data() + neighbour_begin_[v]);
}

std::vector<Vec3> vertex_normals(const SurfaceView& surface, const OneRings& rings) {
    std::vector<Vec3> normals(surface.vertices.size());
    parallel_for(normals.size(), [&](std::size_t v) {
        Vec3 sum = Vec3::Zero();
        for (std::int32_t f : rings.faces(static_cast<std::int32_t>(v))) {
            const Triangle& t = surface.triangles[at(f)];
            const Vec3& a = surface.vertices[at(t[0])];
            sum += (surface.vertices[at(t[1])] - a).cross(surface.vertices[at(t[2])] - a);
        }
        const double length = sum.norm();
        normals[v] = length > 0 ? Vec3(sum / length) : Vec3::Zero();
    });
    return normals;
}

std::vector<std::int32_t> faces_around(const OneRings& rings, std::span<const std::int32_t> vertices) {
    std::vector<std::int32_t> faces;
    for (std::int32_t v : vertices) faces.insert(faces.end(), rings.faces(v).begin(), rings.faces(v).end());
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    return faces;
}

void grow_by_ring(std::span<char> flags, const OneRings& rings) {
    const std::vector<char> inner(flags.begin(), flags.end());
    for (std::size_t v = 0; v < flags.size(); ++v)
        if (std::ranges::any_of(rings.neighbours(static_cast<std::int32_t>(v)),
                                [&](std::int32_t w) { return inner[at(w)] != 0; }))
            flags[v] = 1;
}

std::vector<double> mean_edge_lengths(const SurfaceView& surface, const OneRings& rings) {
    std::vector<double> lengths(surface.vertices.size(), 0.0);
    parallel_for(lengths.size(), [&](std::size_t v) {
        const auto ring = rings.neighbours(static_cast<std::int32_t>(v));
        for (std::int32_t w : ring) lengths[v] += (surface.vertices[at(w)] - surface.vertices[v]).norm();
        if (!ring.empty()) lengths[v] /= static_cast<double>(ring.size());
    });
    return lengths;
}

}  // namespace anyrate
