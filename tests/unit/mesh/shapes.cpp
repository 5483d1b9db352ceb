#include "shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace anyrate::shapes {
namespace {

Mesh icosahedron() {
    const double g = std::numbers::phi;
    Mesh mesh;
    mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                     {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    return mesh;
}

/// Every face in four, with the new vertices at the edges' middles.
Mesh divided(const Mesh& mesh) {
    Mesh fine{.vertices = mesh.vertices, .triangles = {}, .colours = {}};
    std::map<std::pair<int, int>, int> middle;
    const auto middle_of = [&](int a, int b) {
        const auto [place, is_new] = middle.try_emplace(std::minmax(a, b), fine.n_vertices());
        if (is_new) fine.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) / 2);
        return place->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
        const int ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
        for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
            fine.triangles.push_back(t);
    }
    return fine;
}

/// Marching tetrahedra on the Kuhn division of a cubic grid; vertices are shared by the grid edge they lie on.
class TetrahedronMarch {
public:
    TetrahedronMarch(const std::function<double(const Vec3&)>& field, int n) : n_(n) {
        for (int z = 0; z <= n; ++z)
            for (int y = 0; y <= n; ++y)
                for (int x = 0; x <= n; ++x) {
                    points_.push_back(Vec3(x, y, z) * 2.0 / n - Vec3::Ones());
                    const double value = field(points_.back());
                    values_.push_back(value == 0 ? 1e-12 : value);
                }
    }

    Mesh march() {
        std::array<int, 3> axes = {0, 1, 2};
        for (int z = 0; z < n_; ++z)
            for (int y = 0; y < n_; ++y)
                for (int x = 0; x < n_; ++x) do {
                        std::array<int, 4> corner = {node(x, y, z), 0, 0, 0};
                        std::array<int, 3> at = {x, y, z};
                        for (int i = 0; i < 3; ++i) {
                            ++at[axes[i]];
                            corner[i + 1] = node(at[0], at[1], at[2]);
                        }
                        cut(corner);
                    } while (std::next_permutation(axes.begin(), axes.end()));
        return mesh_;
    }

private:
    int node(int x, int y, int z) const { return (z * (n_ + 1) + y) * (n_ + 1) + x; }

    int crossing(int a, int b) {
        const auto [place, is_new] = crossings_.try_emplace(std::minmax(a, b), mesh_.n_vertices());
        const double t = values_[a] / (values_[a] - values_[b]);
        if (is_new) mesh_.vertices.push_back(points_[a] + t * (points_[b] - points_[a]));
        return place->second;
    }

    void cut(std::array<int, 4> corner) {
        const auto outer = std::partition(corner.begin(), corner.end(), [&](int c) { return values_[c] < 0; });
        const auto [p, q, r, s] = corner;
        const Vec3 to_q = points_[q] - points_[p], to_r = points_[r] - points_[p], to_s = points_[s] - points_[p];
        const bool turned = to_q.cross(to_r).dot(to_s) < 0;
        const auto add = [&](int a, int b, int c) {
            mesh_.triangles.push_back(turned ? Triangle{a, c, b} : Triangle{a, b, c});
        };
        switch (outer - corner.begin()) {
            case 1:
                add(crossing(p, q), crossing(p, r), crossing(p, s));
                break;
            case 3:
                add(crossing(p, s), crossing(q, s), crossing(r, s));
                break;
            case 2:
                add(crossing(p, r), crossing(p, s), crossing(q, s));
                add(crossing(p, r), crossing(q, s), crossing(q, r));
                break;
            default:
                break;
        }
    }

    int n_;
    std::vector<Vec3> points_;
    std::vector<double> values_;
    std::map<std::pair<int, int>, int> crossings_;
    Mesh mesh_;
};

}  // namespace

Mesh tetrahedron() {
    return {.vertices = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
            .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
            .colours = {}};
}

Mesh sphere(double radius, int levels) {
    Mesh mesh = icosahedron();
    for (int level = 0; level < levels; ++level) mesh = divided(mesh);
    for (Vec3& v : mesh.vertices) v = radius * v.normalized();
    return mesh;
}

Mesh torus(double major_radius, double minor_radius, int around, int across) {
    Mesh mesh;
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double r = major_radius + minor_radius * std::cos(v);
            mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor_radius * std::sin(v));
            const int i1 = (i + 1) % around, j1 = (j + 1) % across;
            const int a = i * across + j, b = i1 * across + j, c = i1 * across + j1, d = i * across + j1;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        }
    return mesh;
}

Mesh zero_set(const std::function<double(const Vec3&)>& field, int n) { return TetrahedronMarch(field, n).march(); }

Mesh together(const Mesh& a, const Mesh& b) {
    Mesh both = a;
    both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
    both.colours.insert(both.colours.end(), b.colours.begin(), b.colours.end());
    const int shift = a.n_vertices();
    for (const Triangle& t : b.triangles) both.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    return both;
}

Mesh translated(Mesh mesh, const Vec3& by) {
    for (Vec3& v : mesh.vertices) v += by;
    return mesh;
}

}  // namespace anyrate::shapes
