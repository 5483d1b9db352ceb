#include "core/simulation/polygonize.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/parallel.h"

namespace anyrate {
namespace {

using Node = std::array<int, 3>;  // in half cells; the lattice is all nodes with three even or three odd coordinates

/// The field sampled on a body-centred cubic lattice.
class Lattice {
public:
    Lattice(const Field& field, const PolygonizeOptions& options) : low_(options.low), half_(options.cell / 2) {
        for (int axis = 0; axis < 3; ++axis) {
            cells_[axis] = static_cast<int>(std::ceil((options.high[axis] - options.low[axis]) / options.cell));
        }
        values_.resize(2 * plane() * static_cast<std::size_t>(cells_[2] + 1));
        parallel_for(
            2 * static_cast<std::size_t>(cells_[2]) + 1, [&](std::size_t level) { sample(field, level); }, 1);
    }

    const std::array<int, 3>& cells() const { return cells_; }
    Vec3 position(const Node& node) const { return low_ + half_ * Vec3(node[0], node[1], node[2]); }
    double value(const Node& node) const { return values_[index(node)]; }

    /// A number of its own for every node: the two nodes of a cell, corner and centre, are neighbours in memory.
    std::size_t index(const Node& node) const {
        const auto x = static_cast<std::size_t>(node[0] / 2), y = static_cast<std::size_t>(node[1] / 2);
        const auto z = static_cast<std::size_t>(node[2] / 2);
        return z * 2 * plane() + 2 * (y * static_cast<std::size_t>(cells_[0] + 1) + x) + (node[0] & 1);
    }

private:
    std::size_t plane() const {
        return static_cast<std::size_t>(cells_[0] + 1) * static_cast<std::size_t>(cells_[1] + 1);
    }

    void sample(const Field& field, std::size_t level) {
        const int z = static_cast<int>(level);
        for (int y = z & 1; y <= 2 * cells_[1]; y += 2) {
            for (int x = z & 1; x <= 2 * cells_[0]; x += 2) values_[index({x, y, z})] = field(position({x, y, z}));
        }
    }

    Vec3 low_;
    double half_;
    std::array<int, 3> cells_;
    std::vector<double> values_;
};

/// Collects the triangles of one tetrahedron after the other.
class Marcher {
public:
    explicit Marcher(const Lattice& lattice) : lattice_(lattice) {}

    /// @param corners  of a positively oriented tetrahedron
    void march(std::array<Node, 4> corners) {
        // Inside corners first; an odd number of exchanges turns the tetrahedron inside out.
        std::array<bool, 4> inside;
        for (int i = 0; i < 4; ++i) inside[i] = lattice_.value(corners[i]) < 0;
        bool mirrored = false;
        for (int end = 3; end > 0; --end) {
            for (int i = 0; i < end; ++i) {
                if (inside[i] || !inside[i + 1]) continue;
                std::swap(inside[i], inside[i + 1]);
                std::swap(corners[i], corners[i + 1]);
                mirrored = !mirrored;
            }
        }
        const auto cut = [&](int i, int o) { return vertex_between(corners[i], corners[o]); };
        switch (inside[0] + inside[1] + inside[2] + inside[3]) {
            case 1:
                add(cut(0, 1), cut(0, 2), cut(0, 3), mirrored);
                break;
            case 2:
                add(cut(0, 2), cut(0, 3), cut(1, 3), mirrored);
                add(cut(0, 2), cut(1, 3), cut(1, 2), mirrored);
                break;
            case 3:
                add(cut(0, 3), cut(1, 3), cut(2, 3), mirrored);
                break;
            default:
                break;
        }
    }

    Mesh take() { return std::move(mesh_); }

private:
    std::int32_t vertex_between(const Node& inner, const Node& outer) {
        const std::uint64_t key = (static_cast<std::uint64_t>(lattice_.index(inner)) << 32) | lattice_.index(outer);
        const auto [entry, is_new] = vertex_of_edge_.try_emplace(key, mesh_.n_vertices());
        if (is_new) {
            const double a = lattice_.value(inner), b = lattice_.value(outer);
            const double t = a / (a - b);
            mesh_.vertices.push_back((1 - t) * lattice_.position(inner) + t * lattice_.position(outer));
        }
        return entry->second;
    }

    void add(std::int32_t a, std::int32_t b, std::int32_t c, bool mirrored) {
        mesh_.triangles.push_back(mirrored ? Triangle{a, c, b} : Triangle{a, b, c});
    }

    const Lattice& lattice_;
    std::unordered_map<std::uint64_t, std::int32_t> vertex_of_edge_;
    Mesh mesh_;
};

/// The tetrahedra around the edge from `corner` one cell along `axis`: its ends with two neighbouring ones of the four
/// cell centres around it. Corner edges of all cells together give every tetrahedron of the lattice once.
void march_around_edge(Marcher& marcher, const Lattice& lattice, const Node& corner, int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    // A border edge lacks some of its centres; the surface does not come there.
    for (const int side : {u, v}) {
        if (corner[side] == 0 || corner[side] == 2 * lattice.cells()[side]) return;
    }
    Node end = corner;
    end[axis] += 2;
    const auto centre = [&](int du, int dv) {
        Node node = corner;
        node[axis] += 1;
        node[u] += du;
        node[v] += dv;
        return node;
    };
    const std::array<Node, 4> ring{centre(1, 1), centre(-1, 1), centre(-1, -1), centre(1, -1)};
    for (int i = 0; i < 4; ++i) marcher.march({corner, end, ring[i], ring[(i + 1) % 4]});
}

/// Newton's method along the gradient, taken by forward differences. A step is at most a quarter of a cell: at a crease
/// the gradient may mislead.
Vec3 onto_surface(const Field& field, Vec3 p, double cell) {
    constexpr int n_steps = 4;
    const double h = 1e-4 * cell, longest = 0.25 * cell;
    for (int i = 0; i < n_steps; ++i) {
        const double value = field(p);
        Vec3 gradient;
        for (int axis = 0; axis < 3; ++axis) gradient[axis] = (field(p + h * Vec3::Unit(axis)) - value) / h;
        Vec3 step = -value / std::max(gradient.squaredNorm(), 1e-6) * gradient;
        if (step.norm() > longest) step *= longest / step.norm();
        p += step;
    }
    return p;
}

/// The mean of every vertex's neighbours. In a closed mesh every neighbour comes with two triangles.
std::vector<Vec3> neighbour_means(const Mesh& mesh) {
    std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero());
    std::vector<int> counts(mesh.vertices.size(), 0);
    for (const Triangle& triangle : mesh.triangles) {
        for (int i = 0; i < 3; ++i) {
            sums[triangle[i]] += mesh.vertices[triangle[(i + 1) % 3]] + mesh.vertices[triangle[(i + 2) % 3]];
            counts[triangle[i]] += 2;
        }
    }
    for (std::size_t v = 0; v < sums.size(); ++v) sums[v] /= counts[v];
    return sums;
}

}  // namespace

Mesh polygonize(const Field& field, const PolygonizeOptions& options) {
    const Lattice lattice(field, options);
    Marcher marcher(lattice);
    const auto& cells = lattice.cells();
    for (int z = 0; z < cells[2]; ++z) {
        for (int y = 0; y < cells[1]; ++y) {
            for (int x = 0; x < cells[0]; ++x) {
                for (int axis = 0; axis < 3; ++axis) {
                    march_around_edge(marcher, lattice, {2 * x, 2 * y, 2 * z}, axis);
                }
            }
        }
    }
    Mesh mesh = marcher.take();
    constexpr int n_slides = 3;  // turn the slivers of the raw surface into fair triangles; more change little
    for (int slide = 0; slide < n_slides; ++slide) mesh.vertices = neighbour_means(mesh);
    parallel_for(mesh.vertices.size(),
                 [&](std::size_t v) { mesh.vertices[v] = onto_surface(field, mesh.vertices[v], options.cell); });
    return mesh;
}

}  // namespace anyrate
