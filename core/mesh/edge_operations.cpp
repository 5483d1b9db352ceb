#include "core/mesh/edge_operations.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include "core/mesh/closest_point.h"
#include "core/mesh/triangle_shape.h"

namespace anyrate {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

/// How far a triangle may turn in one edit: about 75 degrees. Less would let slivers block their own removal.
constexpr double min_cosine = 0.25;
/// Below this quality a triangle's own normal is noise.
constexpr double sliver_quality = 0.02;
/// A triangle at least this good is good enough not to be compared with what was there before.
constexpr double fair_quality = 0.3;

/// The vertices around one, counter-clockwise.
struct Ring {
    static constexpr int capacity = 64;
    std::array<Vec3, capacity> points;
    int n = 0;

    const Vec3& operator[](int i) const { return points[i < n ? i : i - n]; }
};

/// The ring of the halfedge's origin, from the halfedge's target on. False if it has too many vertices.
bool gather_ring(const Surface& surface, HalfedgeHandle first, Ring& ring) {
    HalfedgeHandle h = first;
    do {
        if (ring.n == Ring::capacity) return false;
        ring.points[ring.n++] = surface.point(surface.to_vertex_handle(h));
        h = surface.opposite_halfedge_handle(surface.prev_halfedge_handle(h));
    } while (h != first);
    return true;
}

Vec3 normal_around(const Vec3& centre, const Ring& ring) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < ring.n; ++i) sum += twice_area_vector(centre, ring[i], ring[i + 1]);
    return sum;
}

double worst_quality(const Vec3& centre, const Ring& ring) {
    double worst = 1;
    for (int i = 0; i < ring.n; ++i) worst = std::min(worst, triangle_quality(centre, ring[i], ring[i + 1]));
    return worst;
}

/// Whether a triangle that replaces another one faces the same way; `around` decides for slivers.
bool keeps_normal(const Vec3& before, double quality_before, const Vec3& after, const Vec3& around) {
    const Vec3& reference = quality_before < sliver_quality ? around : before;
    return after.dot(reference) > min_cosine * after.norm() * reference.norm();
}

/// Whether the ring's triangles from `first` to before `last` keep their normals and a fair shape when the centre
/// moves.
bool keeps_shape(const Vec3& before, const Vec3& after, const Ring& ring, int first, int last) {
    const Vec3 around = normal_around(before, ring);
    const double required = std::min(fair_quality, 0.5 * worst_quality(before, ring));
    for (int i = first; i < last; ++i) {
        const double quality = triangle_quality(before, ring[i], ring[i + 1]);
        if (!keeps_normal(twice_area_vector(before, ring[i], ring[i + 1]), quality,
                          twice_area_vector(after, ring[i], ring[i + 1]), around))
            return false;
        if (triangle_quality(after, ring[i], ring[i + 1]) <= required) return false;
    }
    return true;
}

std::optional<double> collapse_distance(const Surface& surface, HalfedgeHandle h, const CollapseLimits& limits) {
    Ring ring;
    if (!gather_ring(surface, h, ring)) return std::nullopt;
    const Vec3& before = surface.point(surface.from_vertex_handle(h));
    const Vec3& after = ring[0];
    for (int i = 2; i < ring.n - 1; ++i)
        if ((ring[i] - after).squaredNorm() > limits.max_length * limits.max_length) return std::nullopt;
    if (!keeps_shape(before, after, ring, 1, ring.n - 1)) return std::nullopt;
    double d2 = std::numeric_limits<double>::infinity();
    for (int i = 1; i < ring.n - 1; ++i)
        d2 = std::min(d2, (closest_point_on_triangle(before, after, ring[i], ring[i + 1]) - before).squaredNorm());
    if (d2 > limits.max_distance * limits.max_distance) return std::nullopt;
    return std::sqrt(d2);
}

/// The link condition, and no vertex is left with two neighbours.
bool is_collapse_manifold(Surface& surface, HalfedgeHandle h) {
    const auto apex = [&](HalfedgeHandle side) { return surface.to_vertex_handle(surface.next_halfedge_handle(side)); };
    return surface.valence(apex(h)) > 3 && surface.valence(apex(surface.opposite_halfedge_handle(h))) > 3 &&
           surface.is_collapse_ok(h);
}

/// An edge with its two triangles (a, b, c) and (b, a, d).
struct Diamond {
    VertexHandle a, b, c, d;
    Diamond(const Surface& surface, EdgeHandle e) {
        const HalfedgeHandle h = surface.halfedge_handle(e, 0), twin = surface.halfedge_handle(e, 1);
        a = surface.from_vertex_handle(h);
        b = surface.to_vertex_handle(h);
        c = surface.to_vertex_handle(surface.next_halfedge_handle(h));
        d = surface.to_vertex_handle(surface.next_halfedge_handle(twin));
    }
};

/// By how much the flip lowers the sum of squared distances of the valences to six.
int valence_gain(const Surface& surface, const Diamond& edge) {
    const auto excess = [&](VertexHandle v) { return static_cast<int>(surface.valence(v)) - 6; };
    // (x-1)^2 = x^2 - 2x + 1 at the ends that lose the edge, (x+1)^2 = x^2 + 2x + 1 at those that gain it.
    return 2 * (excess(edge.a) + excess(edge.b) - excess(edge.c) - excess(edge.d)) - 4;
}

/// Whether the angles opposite of edge ab sum to more than 180 degrees, with some slack against endless flips.
bool is_not_delaunay(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const auto cotangent = [&](const Vec3& apex) {
        const Vec3 u = a - apex, v = b - apex;
        return u.dot(v) / std::max(u.cross(v).norm(), std::numeric_limits<double>::min());
    };
    return cotangent(c) + cotangent(d) < -1e-6;
}

bool is_flip_good(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 old1 = twice_area_vector(a, b, c), old2 = twice_area_vector(b, a, d);
    const Vec3 new1 = twice_area_vector(c, d, b), new2 = twice_area_vector(d, c, a);
    const Vec3 mean = old1 + old2;
    const auto cosine = [](const Vec3& u, const Vec3& v) {
        return u.dot(v) / std::max(u.norm() * v.norm(), std::numeric_limits<double>::min());
    };
    if (cosine(new1, mean) < 0.5 || cosine(new2, mean) < 0.5) return false;
    const double quality_before = std::min(triangle_quality(a, b, c), triangle_quality(b, a, d));
    const double bend_before = quality_before < sliver_quality ? 0 : cosine(old1, old2);
    if (cosine(new1, new2) < std::min(0.8, bend_before)) return false;
    const double quality_after = std::min(triangle_quality(c, d, b), triangle_quality(d, c, a));
    return quality_after > std::min(fair_quality, quality_before);
}

}  // namespace

std::optional<double> collapse(Surface& surface, HalfedgeHandle h, const CollapseLimits& limits) {
    const std::optional<double> distance = collapse_distance(surface, h, limits);
    if (!distance || !is_collapse_manifold(surface, h)) return std::nullopt;
    surface.collapse(h);
    return distance;
}

bool collapse_blindly(Surface& surface, HalfedgeHandle h) {
    if (!is_collapse_manifold(surface, h)) return false;
    surface.collapse(h);
    return true;
}

bool flip_to_improve(Surface& surface, EdgeHandle e) {
    const Diamond edge(surface, e);
    const int gain = valence_gain(surface, edge);
    if (gain < 0 || surface.valence(edge.a) <= 3 || surface.valence(edge.b) <= 3) return false;
    const Vec3 &a = surface.point(edge.a), &b = surface.point(edge.b);
    const Vec3 &c = surface.point(edge.c), &d = surface.point(edge.d);
    if (gain == 0 && !is_not_delaunay(a, b, c, d)) return false;
    if (!is_flip_good(a, b, c, d) || !surface.is_flip_ok(e)) return false;
    surface.flip(e);
    return true;
}

bool move(Surface& surface, VertexHandle v, const Vec3& to) {
    Ring ring;
    if (!gather_ring(surface, surface.halfedge_handle(v), ring)) return false;
    if (!keeps_shape(surface.point(v), to, ring, 0, ring.n)) return false;
    surface.set_point(v, to);
    return true;
}

Vec3 ring_normal(const Surface& surface, VertexHandle v) {
    Vec3 sum = Vec3::Zero();
    const Vec3& p = surface.point(v);
    const HalfedgeHandle first = surface.halfedge_handle(v);
    HalfedgeHandle h = first;
    do {
        const HalfedgeHandle next = surface.opposite_halfedge_handle(surface.prev_halfedge_handle(h));
        sum += twice_area_vector(p, surface.point(surface.to_vertex_handle(h)),
                                 surface.point(surface.to_vertex_handle(next)));
        h = next;
    } while (h != first);
    return sum;
}

double squared_length(const Surface& surface, EdgeHandle e) {
    const HalfedgeHandle h = surface.halfedge_handle(e, 0);
    return (surface.point(surface.to_vertex_handle(h)) - surface.point(surface.from_vertex_handle(h))).squaredNorm();
}

}  // namespace anyrate
