#include "shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

namespace anyrate::shapes {
namespace {

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
