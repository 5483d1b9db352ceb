#include "core/mesh/remesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <string>

#include "core/error.h"
#include "core/mesh/edge_operations.h"
#include "core/mesh/nearest_surface.h"
#include "core/mesh/topology.h"
#include "core/mesh/triangle_shape.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

/// Rounds at the end that leave the count alone and only even out.
constexpr int n_polishing_rounds = 4;

/// Edges shorter than this part of the wanted ones are collapsed whatever their triangles look like: marching
/// tetrahedra leave clusters of vertices in next to one place, with triangles that face anywhere.
constexpr double noise_length = 0.01;

/// What part of an edge a point of the input may be off the mesh before a vertex reaches out for it.
constexpr double least_reach = 0.4;
constexpr std::size_t samples_a_vertex = 8;

/// Of the even length: edges where longer ones miss the input. They are told half-way, when the mesh is even enough to
/// ask and rounds enough are left to shorten them.
constexpr double detail_scale = 0.5;

class Remesher {
public:
    explicit Remesher(const Mesh& mesh) : input_(mesh), target_(mesh), surface_(to_surface(mesh)) {
        surface_.add_property(face_);
        surface_.add_property(eroded_);
        surface_.add_property(scale_);
        for (const VertexHandle v : surface_.vertices()) {
            surface_.property(face_, v) = -1;
            surface_.property(scale_, v) = 1;
        }
    }

    Mesh run(const RemeshOptions& options) {
        n_wanted_ = options.n_vertices;
        detail_ = options.detail;
        const int detail_round = options.iterations / 2;
        thin_out(3 * n_wanted_);
        double correction = 1;
        for (int round = 0; round < options.iterations; ++round) {
            const double length = correction * even_length(n_wanted_);
            split_longer_than(4.0 / 3.0 * length);
            collapse_shorter_than(4.0 / 5.0 * length, 4.0 / 3.0 * length);
            improve_valences();
            if (round % 2 == 1) reach_out(length);
            if (detail_ > 0 && round == detail_round) shorten_edges(detail_ * length);
            relax();
            if (detail_ == 0 || round < detail_round)
                correction *= std::sqrt(static_cast<double>(surface_.n_vertices()) / n_wanted_);
        }
        meet_count();
        for (int round = 0; round < n_polishing_rounds; ++round) {
            improve_valences();
            relax();
        }
        settle();
        return to_mesh(surface_);
    }

private:
    /// The edge length of n vertices in a regular triangulation of the surface's area: sqrt(3)/2 length^2 a vertex.
    double even_length(int n) const {
        double twice_area = 0;
        for (const auto f : surface_.faces()) {
            const HalfedgeHandle h = surface_.halfedge_handle(f);
            twice_area += twice_area_vector(from(h), to(h), to(surface_.next_halfedge_handle(h))).norm();
        }
        return std::sqrt(twice_area / (std::numbers::sqrt3 * n));
    }

    /// Collapses short edges of a dense mesh, the shortest first, until about n vertices are left.
    void thin_out(int n) {
        const double length = even_length(n);
        int n_left = static_cast<int>(surface_.n_vertices());
        for (double part = 0.25; part < 1.5 && n_left > n; part += 0.15) {
            const double bound = part * length;
            for (std::size_t i = 0; i < surface_.n_edges() && n_left > n; ++i)
                n_left -= collapse_if_shorter(EdgeHandle(static_cast<int>(i)), bound, 2 * bound);
        }
        surface_.garbage_collection();
    }

    bool collapse_if_shorter(EdgeHandle e, double bound, double max_length) {
        if (surface_.status(e).deleted()) return false;
        const double length2 = squared_length(surface_, e), scale = scale_of(e);
        bound *= scale;
        max_length *= scale;
        if (length2 >= bound * bound) return false;
        if (length2 < noise_length * noise_length * bound * bound)
            return collapse_blindly(surface_, surface_.halfedge_handle(e, 0));
        return collapse_either_way(e, {.max_length = max_length, .max_distance = 0.3 * bound});
    }

    /// The end with the smaller valence goes first: that evens out the valences.
    bool collapse_either_way(EdgeHandle e, const CollapseLimits& limits) {
        HalfedgeHandle h = surface_.halfedge_handle(e, 0);
        if (surface_.valence(surface_.from_vertex_handle(h)) > surface_.valence(surface_.to_vertex_handle(h)))
            h = surface_.opposite_halfedge_handle(h);
        return collapse_one_way(h, limits) || collapse_one_way(surface_.opposite_halfedge_handle(h), limits);
    }

    /// Each vertex remembers how far off the vertices may be that went into it: many small steps would eat up a tip.
    bool collapse_one_way(HalfedgeHandle h, CollapseLimits limits) {
        const VertexHandle from = surface_.from_vertex_handle(h), to = surface_.to_vertex_handle(h);
        limits.max_distance -= surface_.property(eroded_, from);
        if (limits.max_distance <= 0) return false;
        const std::optional<double> distance = collapse(surface_, h, limits);
        if (!distance) return false;
        double& eroded = surface_.property(eroded_, to);
        eroded = std::max(eroded, surface_.property(eroded_, from) + *distance);
        return true;
    }

    void collapse_shorter_than(double bound, double max_length) {
        for (std::size_t i = 0; i < surface_.n_edges(); ++i)
            collapse_if_shorter(EdgeHandle(static_cast<int>(i)), bound, max_length);
        surface_.garbage_collection();
    }

    void split_longer_than(double bound) {
        const std::size_t n_edges = surface_.n_edges();  // the halves are looked at in the next round
        for (std::size_t i = 0; i < n_edges; ++i) {
            const EdgeHandle e(static_cast<int>(i));
            const double scale = scale_of(e);
            if (squared_length(surface_, e) > bound * bound * scale * scale) split(e);
        }
    }

    /// At the middle, which then goes to the input surface unless that folds something over.
    VertexHandle split(EdgeHandle e) {
        const HalfedgeHandle h = surface_.halfedge_handle(e, 0);
        const Vec3 middle = (from(h) + to(h)) / 2;
        const std::int32_t hint = surface_.property(face_, surface_.from_vertex_handle(h));
        const VertexHandle v = surface_.add_vertex(middle);
        surface_.property(scale_, v) = scale_of(e);
        surface_.split(e, v);
        const NearestSurface::Hit hit = project(middle, ring_normal(surface_, v), hint);
        surface_.property(face_, v) = hit.face;
        move(surface_, v, hit.point);
        return v;
    }

    void improve_valences() {
        for (std::size_t i = 0; i < surface_.n_edges(); ++i) flip_to_improve(surface_, EdgeHandle(static_cast<int>(i)));
    }

    /// Every vertex goes towards the centre of its ring along the tangent plane, and back to the input surface.
    void relax() {
        std::vector<Vec3> place(surface_.n_vertices());
        parallel_for(place.size(), [&](std::size_t i) {
            const VertexHandle v(static_cast<int>(i));
            const Vec3 normal = ring_normal(surface_, v).stableNormalized();
            const Vec3 step = ring_centre(v) - surface_.point(v);
            const Vec3 wanted = surface_.point(v) + step - normal * normal.dot(step);
            const NearestSurface::Hit hit = project(wanted, normal, surface_.property(face_, v));
            surface_.property(face_, v) = hit.face;
            place[i] = hit.point;
        });
        for (std::size_t i = 0; i < place.size(); ++i) move(surface_, VertexHandle(static_cast<int>(i)), place[i]);
    }

    /// Brings to the input surface also those whose way there was refused so far; the others are there.
    void settle() {
        for (const VertexHandle v : surface_.vertices())
            surface_.set_point(v, target_.nearest(surface_.point(v), surface_.property(face_, v)).point);
    }

    /// A vertex of the input beside the mesh.
    struct Sample {
        std::size_t vertex = 0;
        NearestSurface::Hit hit;  ///< on the mesh
    };

    /// Asks a sample of the input's vertices, a few for each vertex of the mesh, how far off it they are.
    std::vector<Sample> sample_input(const Mesh& mesh) const {
        const NearestSurface nearest(mesh);
        const std::size_t stride =
            std::max<std::size_t>(1, input_.vertices.size() / (samples_a_vertex * mesh.vertices.size()));
        std::vector<Sample> samples(input_.vertices.size() / stride);
        parallel_for(samples.size(), [&](std::size_t i) {
            samples[i] = {i * stride, nearest.nearest(input_.vertices[i * stride])};
        });
        return samples;
    }

    /// Pulls vertices to points of the input that lie off the mesh by a part of an edge, so that tips and rims which
    /// collapses have eaten grow back.
    void reach_out(double length) {
        const Mesh mesh = to_mesh(surface_);
        std::vector<const Sample*> farthest(mesh.vertices.size(), nullptr);  // the one to go to
        const std::vector<Sample> samples = sample_input(mesh);
        for (const Sample& sample : samples) {
            const double distance = std::sqrt(sample.hit.squared_distance);
            if (distance < least_reach * length || distance > length) continue;
            const Vec3& p = input_.vertices[sample.vertex];
            const auto& corners = mesh.triangles[sample.hit.face];
            const auto v = *std::ranges::min_element(
                corners, {}, [&](std::int32_t c) { return (mesh.vertices[c] - p).squaredNorm(); });
            if (!farthest[v] || sample.hit.squared_distance > farthest[v]->hit.squared_distance) farthest[v] = &sample;
        }
        for (std::size_t v = 0; v < farthest.size(); ++v)
            if (farthest[v]) move(surface_, VertexHandle(static_cast<int>(v)), input_.vertices[farthest[v]->vertex]);
    }

    /// Edges are wanted shorter around the vertices where the input is off the mesh, and around their neighbours.
    /// @param distance  root mean square around a vertex, from which on it is
    void shorten_edges(double distance) {
        const Mesh mesh = to_mesh(surface_);
        std::vector<double> sum(mesh.vertices.size(), 0.0);
        std::vector<int> n(mesh.vertices.size(), 0);
        for (const Sample& sample : sample_input(mesh))
            for (const std::int32_t v : mesh.triangles[sample.hit.face]) {
                sum[v] += sample.hit.squared_distance;
                ++n[v];
            }
        const auto is_off = [&](std::int32_t v) { return sum[v] > n[v] * distance * distance; };
        for (const Triangle& t : mesh.triangles)
            if (std::ranges::any_of(t, is_off))
                for (const std::int32_t v : t) surface_.property(scale_, VertexHandle(v)) = detail_scale;
    }

    /// The centre of gravity of the triangles around a vertex.
    Vec3 ring_centre(VertexHandle v) const {
        Vec3 sum = Vec3::Zero();
        double area = 0;
        const HalfedgeHandle first = surface_.halfedge_handle(v);
        HalfedgeHandle h = first;
        do {
            const HalfedgeHandle next = surface_.opposite_halfedge_handle(surface_.prev_halfedge_handle(h));
            const double a = twice_area_vector(from(h), to(h), to(next)).norm();
            sum += a * (from(h) + to(h) + to(next));
            area += a;
            h = next;
        } while (h != first);
        return area > 0 ? Vec3(sum / (3 * area)) : surface_.point(v);
    }

    /// To the side of the input that faces the same way; to any if there is none.
    NearestSurface::Hit project(const Vec3& p, const Vec3& normal, std::int32_t hint) const {
        const NearestSurface::Hit hit = target_.nearest_facing(p, normal, hint);
        return hit.face >= 0 ? hit : target_.nearest(p, hint);
    }

    /// Single splits of the longest or collapses of the shortest edges. More than the count are what detail adds.
    void meet_count() {
        int n = static_cast<int>(surface_.n_vertices());
        if (n > n_wanted_ && detail_ == 0) collapse_shortest(n - n_wanted_);
        if (n < n_wanted_) split_longest(n_wanted_ - n);
    }

    struct Ranked {
        double rank;
        int edge;
        friend bool operator<(const Ranked& a, const Ranked& b) {
            return std::pair(a.rank, a.edge) < std::pair(b.rank, b.edge);
        }
    };

    void split_longest(int count) {
        std::priority_queue<Ranked> longest;
        for (const EdgeHandle e : surface_.edges()) longest.push({squared_length(surface_, e), e.idx()});
        while (count > 0) {
            const Ranked top = longest.top();
            longest.pop();
            const EdgeHandle e(top.edge);
            if (top.rank != squared_length(surface_, e)) continue;  // changed since: it was pushed again
            const VertexHandle v = split(e);
            --count;
            for (const EdgeHandle changed : surface_.ve_range(v))
                longest.push({squared_length(surface_, changed), changed.idx()});
        }
    }

    void collapse_shortest(int count) {
        std::priority_queue<Ranked> shortest;
        for (const EdgeHandle e : surface_.edges()) shortest.push({-squared_length(surface_, e), e.idx()});
        while (count > 0 && !shortest.empty()) {
            const Ranked top = shortest.top();
            shortest.pop();
            const EdgeHandle e(top.edge);
            if (surface_.status(e).deleted() || -top.rank != squared_length(surface_, e)) continue;
            const HalfedgeHandle h = surface_.halfedge_handle(e, 0);
            const VertexHandle ends[2] = {surface_.from_vertex_handle(h), surface_.to_vertex_handle(h)};
            const double length = std::sqrt(-top.rank);
            if (!collapse_either_way(e, {.max_length = 4 * length, .max_distance = 0.5 * length})) continue;
            --count;
            const VertexHandle kept = surface_.status(ends[0]).deleted() ? ends[1] : ends[0];
            for (const EdgeHandle changed : surface_.ve_range(kept))
                shortest.push({-squared_length(surface_, changed), changed.idx()});
        }
        surface_.garbage_collection();
    }

    double scale_of(EdgeHandle e) const {
        const HalfedgeHandle h = surface_.halfedge_handle(e, 0);
        return 0.5 * (surface_.property(scale_, surface_.from_vertex_handle(h)) +
                      surface_.property(scale_, surface_.to_vertex_handle(h)));
    }

    const Vec3& from(HalfedgeHandle h) const { return surface_.point(surface_.from_vertex_handle(h)); }
    const Vec3& to(HalfedgeHandle h) const { return surface_.point(surface_.to_vertex_handle(h)); }

    const Mesh& input_;
    NearestSurface target_;  ///< of the input
    Surface surface_;
    OpenMesh::VPropHandleT<double> eroded_;      ///< how far off the vertices may be that went into each
    OpenMesh::VPropHandleT<double> scale_;       ///< of the edges wanted around each, in parts of the even ones
    OpenMesh::VPropHandleT<std::int32_t> face_;  ///< the input face each vertex was last projected to
    int n_wanted_ = 0;
    double detail_ = 0;
};

}  // namespace

Mesh remesh_isotropic(const Mesh& mesh, const RemeshOptions& options) {
    const Topology topology = measure_topology(mesh);
    if (!topology.is_closed_manifold()) throw InputError("remesh: expected a closed manifold");
    for (int v = 0; v < mesh.n_vertices(); ++v)
        if (!mesh.vertices[v].allFinite()) throw InputError("remesh: vertex " + std::to_string(v) + " is not finite");
    if (options.n_vertices < 4 * topology.n_components)
        throw InputError("remesh: expected at least 4 vertices a piece, got " + std::to_string(options.n_vertices) +
                         " for " + std::to_string(topology.n_components));
    Mesh even = Remesher(mesh).run(options);
    const bool is_too_few = even.n_vertices() < 0.98 * options.n_vertices,
               is_too_many = options.detail == 0 && even.n_vertices() > 1.02 * options.n_vertices;
    if (is_too_few || is_too_many)
        throw InputError("remesh: " + std::to_string(options.n_vertices) + " vertices cannot carry the surface, got " +
                         std::to_string(even.n_vertices()));
    return even;
}

}  // namespace anyrate
