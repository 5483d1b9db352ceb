#include "core/mesh/nearest_surface.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "core/error.h"
#include "core/mesh/closest_point.h"

namespace anyrate {
namespace {

constexpr std::int32_t leaf_size = 4;
constexpr int max_depth = 40;  // halving 2^31 triangles takes 29 levels

}  // namespace

NearestSurface::NearestSurface(const Mesh& mesh) : face_(mesh.triangles.size()), place_(mesh.triangles.size()) {
    if (mesh.triangles.empty()) throw InputError("nearest point: expected a mesh with triangles");
    std::vector<Corners> faces;
    faces.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        faces.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    std::iota(face_.begin(), face_.end(), 0);
    nodes_.reserve(faces.size());
    build(faces, 0, mesh.n_faces());
    triangles_.reserve(faces.size());
    for (std::int32_t i = 0; i < mesh.n_faces(); ++i) {
        triangles_.push_back(faces[face_[i]]);
        place_[face_[i]] = i;
    }
}

void NearestSurface::build(const std::vector<Corners>& faces, std::int32_t begin, std::int32_t end) {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Eigen::AlignedBox3d box;
    if (end - begin <= leaf_size) {
        for (std::int32_t i = begin; i < end; ++i)
            for (const Vec3& corner : {faces[face_[i]].a, faces[face_[i]].b, faces[face_[i]].c}) box.extend(corner);
        nodes_[self] = {.box = box, .begin = begin, .end = end, .right = 0};
        return;
    }
    const auto centre = [&](std::int32_t f) -> Vec3 { return faces[f].a + faces[f].b + faces[f].c; };  // times 3
    for (std::int32_t i = begin; i < end; ++i) box.extend(centre(face_[i]));
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::int32_t middle = begin + (end - begin) / 2;
    std::nth_element(face_.begin() + begin, face_.begin() + middle, face_.begin() + end,
                     [&](std::int32_t f, std::int32_t g) {
                         const double x = faces[f].a[axis] + faces[f].b[axis] + faces[f].c[axis];
                         const double y = faces[g].a[axis] + faces[g].b[axis] + faces[g].c[axis];
                         return std::tie(x, f) < std::tie(y, g);
                     });
    build(faces, begin, middle);
    const auto right = static_cast<std::int32_t>(nodes_.size());
    build(faces, middle, end);
    nodes_[self] = {.box = nodes_[self + 1].box.merged(nodes_[right].box), .begin = 0, .end = 0, .right = right};
}

template <class Accepts>
NearestSurface::Hit NearestSurface::search(const Vec3& p, std::int32_t hint, const Accepts& accepts) const {
    Hit best;
    const auto visit = [&](std::int32_t i) {
        const Corners& t = triangles_[i];
        if (!accepts(t)) return;
        const Vec3 q = closest_point_on_triangle(p, t.a, t.b, t.c);
        const double d2 = (q - p).squaredNorm();
        if (d2 < best.squared_distance) best = {.point = q, .face = face_[i], .squared_distance = d2};
    };
    if (hint >= 0) visit(place_[hint]);
    struct Pending {
        std::int32_t node;
        double squared_distance;
    };
    std::array<Pending, max_depth> stack;
    int n_pending = 0;
    stack[n_pending++] = {0, nodes_[0].box.squaredExteriorDistance(p)};
    while (n_pending > 0) {
        const Pending top = stack[--n_pending];
        if (top.squared_distance >= best.squared_distance) continue;
        const Node& node = nodes_[top.node];
        for (std::int32_t i = node.begin; i < node.end; ++i) visit(i);
        if (node.right == 0) continue;
        Pending near{top.node + 1, nodes_[top.node + 1].box.squaredExteriorDistance(p)};
        Pending far{node.right, nodes_[node.right].box.squaredExteriorDistance(p)};
        if (far.squared_distance < near.squared_distance) std::swap(near, far);
        if (far.squared_distance < best.squared_distance) stack[n_pending++] = far;
        stack[n_pending++] = near;
    }
    return best;
}

NearestSurface::Hit NearestSurface::nearest(const Vec3& p, std::int32_t hint) const {
    return search(p, hint, [](const Corners&) { return true; });
}

NearestSurface::Hit NearestSurface::nearest_facing(const Vec3& p, const Vec3& direction, std::int32_t hint) const {
    return search(p, hint, [&](const Corners& t) { return (t.b - t.a).cross(t.c - t.a).dot(direction) > 0; });
}

}  // namespace anyrate
