#include "core/mesh/nearest_surface.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

#include "core/error.h"
#include "core/mesh/closest_point.h"

namespace anyrate {
namespace {

constexpr int most_pending = 64;    // three a level, and 4^16 is more triangles than there can be
constexpr float precision = 1e-6F;  // of numbers computed in single precision, with a margin

/// Four numbers, none below 0, the largest first, as their bits, whose order is theirs; the last two bits say which one
/// it was. Without a branch, since each would be a coin's toss.
std::array<std::int32_t, 4> farthest_first(const Float4& numbers) {
    std::array<std::int32_t, 4> keys;
    std::memcpy(keys.data(), &numbers, sizeof keys);
    for (std::int32_t k = 0; k < 4; ++k) keys[k] = (keys[k] & ~3) | k;
    const auto order = [&](std::size_t i, std::size_t j) {
        const std::int32_t larger = std::max(keys[i], keys[j]);
        keys[j] = std::min(keys[i], keys[j]);
        keys[i] = larger;
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    return keys;
}

float below(double x, float slack) { return static_cast<float>(x) - slack; }
float above(double x, float slack) { return static_cast<float>(x) + slack; }

}  // namespace

NearestSurface::NearestSurface(const Mesh& mesh) : face_(mesh.triangles.size()), place_(mesh.triangles.size()) {
    if (mesh.triangles.empty()) throw InputError("nearest point: expected a mesh with triangles");
    std::vector<Box> boxes(mesh.triangles.size());
    Box whole;
    for (std::size_t f = 0; f < boxes.size(); ++f) {
        for (const std::int32_t v : mesh.triangles[f]) boxes[f].extend(mesh.vertices[v]);
        whole.extend(boxes[f]);
    }
    centre_ = whole.center();
    slack_ = precision * static_cast<float>(whole.sizes().maxCoeff());
    std::iota(face_.begin(), face_.end(), 0);
    nodes_.reserve(boxes.size() / 2 + 1);
    build(boxes, 0, mesh.n_faces());
    triangles_.reserve(face_.size());
    for (std::int32_t i = 0; i < mesh.n_faces(); ++i) {
        const auto& [a, b, c] = mesh.triangles[face_[i]];
        triangles_.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
        place_[face_[i]] = i;
    }
}

NearestSurface::Box NearestSurface::build(std::span<const Box> boxes, std::int32_t begin, std::int32_t end) {
    // Halves along the longest side of their centres' box, each of which is halved again.
    const auto halve = [&](std::int32_t from, std::int32_t to) {
        const std::int32_t middle = from + (to - from + 1) / 2;
        if (to - from < 2) return middle;
        Box centres;
        for (std::int32_t i = from; i < to; ++i) centres.extend(boxes[face_[i]].center());
        int axis = 0;
        centres.sizes().maxCoeff(&axis);
        std::nth_element(face_.begin() + from, face_.begin() + middle, face_.begin() + to,
                         [&](std::int32_t f, std::int32_t g) {
                             const double x = boxes[f].min()[axis] + boxes[f].max()[axis],
                                          y = boxes[g].min()[axis] + boxes[g].max()[axis];
                             return std::tie(x, f) < std::tie(y, g);
                         });
        return middle;
    };
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    const std::int32_t middle = halve(begin, end);
    const std::int32_t ends[] = {begin, halve(begin, middle), middle, halve(middle, end), end};
    Box all;
    for (std::size_t k = 0; k < width; ++k) {
        const std::int32_t from = ends[k], to = ends[k + 1];
        // A child that is not there stands for a triangle again, infinitely far away.
        const auto child = to - from > 1 ? static_cast<std::int32_t>(nodes_.size()) : ~std::min(from, end - 1);
        const Box box = to == from ? Box() : to - from == 1 ? boxes[face_[from]] : build(boxes, from, to);
        Node& node = nodes_[self];
        node.child[k] = child;
        for (int axis = 0; axis < 3; ++axis) {
            constexpr float far = std::numeric_limits<float>::max();
            node.lower[axis][k] = box.isEmpty() ? far : below(box.min()[axis] - centre_[axis], slack_);
            node.upper[axis][k] = box.isEmpty() ? -far : above(box.max()[axis] - centre_[axis], slack_);
        }
        all.extend(box);
    }
    return all;
}

template <class Accepts>
NearestSurface::Hit NearestSurface::search(const Vec3& p, std::int32_t hint, const Accepts& accepts) const {
    Hit best;
    float reach = std::numeric_limits<float>::infinity();  // squared
    const auto visit = [&](std::int32_t place) {
        const Corners& t = triangles_[place];
        if (!accepts(t)) return;
        const Vec3 q = closest_point_on_triangle(p, t.a, t.b, t.c);
        const double d2 = (q - p).squaredNorm();
        if (!(d2 < best.squared_distance)) return;
        best = {.point = q, .face = face_[place], .squared_distance = d2};
        reach = static_cast<float>(d2);
    };
    if (hint >= 0) visit(place_[hint]);
    const Vec3 from = p - centre_;
    const float x[] = {static_cast<float>(from.x()), static_cast<float>(from.y()), static_cast<float>(from.z())};
    struct Pending {
        std::int32_t child;
        float squared_distance;  // to its box or less
    };
    std::array<Pending, most_pending> stack;
    stack[0] = {0, 0.0F};
    for (int n_pending = 1; n_pending > 0;) {
        const Pending top = stack[--n_pending];
        if (top.squared_distance > reach) continue;
        if (top.child < 0) {
            visit(~top.child);
            continue;
        }
        const Node& node = nodes_[top.child];
        Float4 squared_distance{};
        for (int axis = 0; axis < 3; ++axis) {
            const Float4 under = node.lower[axis] - x[axis], over = x[axis] - node.upper[axis];
            Float4 outside = under < over ? over : under;
            outside = outside < 0 ? Float4{} : outside;
            squared_distance += outside * outside;
        }
        for (const std::int32_t key : farthest_first(squared_distance * (1 - 4 * precision))) {
            const float distance = std::bit_cast<float>(key);
            stack[n_pending] = {node.child[key & 3], distance};  // taken back if it is too far away
            n_pending += distance <= reach ? 1 : 0;
        }
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
