#include "core/reconstruction/iso_surface.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <span>
#include <utility>

namespace anyrate {
namespace {

// Marching cubes with its polygons traced instead of looked up (after Lorensen and Cline 1987; saddle rule of Nielson
// and Hamann 1991). A node is inside if its value is negative; zero counts as positive, so no node lies on the surface.
// Every cell edge whose ends differ carries one vertex, shared by the four cells around it. In each cell face the
// vertices are joined in pairs by segments, by a rule that looks at the face's own four values only; the segments of a
// cell's six faces close to loops, and each loop is filled by a disk.
//
// Why the result is a closed, consistently oriented manifold:
// - a vertex lies in two faces of a cell, and in each of them it ends exactly one segment: so a cell's segments form
//   disjoint simple loops, and a vertex is passed once by one loop of each of the four cells around its edge;
// - the two cells of a face draw the same segments in it, in opposite directions: a segment has two disks, consistently
//   oriented. The border is outside, so no segment lies in a face of one cell only;
// - the edges that fill a disk belong to it alone: larger loops are filled from a centre vertex of their own, and the
//   diagonal of a loop of four joins two cell edges that share no face (such a loop goes round one cell edge or cuts
//   four parallel ones), so neither another loop nor another cell draws it;
// - so the disks at a vertex form one cycle through the four cells around its edge, and those at a centre one fan.

// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2); edge 4a + b + 2d runs along axis a, from where the coordinates
// of axes a+1 and a+2 (cyclic) are b and d.
constexpr int corner_bit(int corner, int axis) { return corner >> axis & 1; }

constexpr int edge_between(int corner_a, int corner_b) {
    const int difference = corner_a ^ corner_b;
    const int axis = difference == 1 ? 0 : difference == 2 ? 1 : 2;
    return 4 * axis + corner_bit(corner_a, (axis + 1) % 3) + 2 * corner_bit(corner_a, (axis + 2) % 3);
}

struct Face {
    std::array<int, 4> corners;  // counter-clockwise seen from outside the cell
    std::array<int, 4> edges;    // edges[n] joins corners n and n + 1
};

constexpr std::array<Face, 6> make_faces() {
    std::array<Face, 6> faces{};
    for (int axis = 0; axis < 3; ++axis) {
        const int b = 1 << (axis + 1) % 3;
        const int d = 1 << (axis + 2) % 3;
        const int far = 1 << axis;
        faces[static_cast<std::size_t>(2 * axis)].corners = {0, d, b | d, b};
        faces[static_cast<std::size_t>(2 * axis + 1)].corners = {far, far | b, far | b | d, far | d};
    }
    for (Face& face : faces)
        for (std::size_t n = 0; n < 4; ++n) face.edges[n] = edge_between(face.corners[n], face.corners[(n + 1) % 4]);
    return faces;
}
constexpr std::array<Face, 6> faces = make_faces();

using CornerValues = std::array<float, 8>;
constexpr int no_edge = -1;

// Writes next[e] for every edge e at which a segment of this face starts. Walking round the face, the surface is met
// where the walk enters the inside and where it leaves; a segment runs from an entry to an exit, which keeps the inside
// on the side that makes the loops counter-clockwise seen from the positive side.
void join_face(const Face& face, const CornerValues& values, std::array<int, 12>& next) {
    const auto value = [&](std::size_t n) { return values[static_cast<std::size_t>(face.corners[n % 4])]; };
    const auto inside = [&](std::size_t n) { return value(n) < 0.0f; };
    const bool crossed_four_times = inside(0) != inside(1) && inside(1) != inside(2) && inside(2) != inside(3);
    // Nielson and Hamann 1991: the bilinear saddle is inside if the product of the inner corners is the greater one;
    // then the two inner corners hang together and each segment cuts off an outer corner.
    const float even = value(0) * value(2);
    const float odd = value(1) * value(3);
    const bool joined = crossed_four_times && (inside(0) ? even > odd : odd > even);
    for (std::size_t n = 0; n < 4; ++n) {
        if (inside(n) || !inside(n + 1)) continue;
        std::size_t exit = n + 1;
        while (!inside(exit) || inside(exit + 1)) ++exit;  // the next exit cuts off the inner corners passed
        if (joined) exit += 2;                             // the other one cuts off the outer corners before the entry
        next[static_cast<std::size_t>(face.edges[n])] = face.edges[exit % 4];
    }
}

// Numbers of the vertices on the edges of one layer of cells, and of their making.
class LayerVertices {
public:
    LayerVertices(const ScalarField& field, Mesh& mesh) : field_(field), mesh_(mesh) {
        const auto n = static_cast<std::size_t>(field.nx) * static_cast<std::size_t>(field.ny);
        for (auto* plane : {&x_[0], &x_[1], &y_[0], &y_[1], &z_}) plane->resize(n);
        make_plane(0, 1);
    }

    // Moves on to the cells between node planes k and k + 1.
    void enter_layer(int k) {
        std::swap(x_[0], x_[1]);
        std::swap(y_[0], y_[1]);
        for (int j = 0; j < field_.ny; ++j)
            for (int i = 0; i < field_.nx; ++i) z_[node(i, j)] = make_vertex(i, j, k, 2);
        make_plane(k + 1, 1);
    }

    std::int32_t at(int i, int j, int edge) const {
        const int b = edge & 1;
        const auto d = edge >> 1 & 1;
        switch (edge >> 2) {
            case 0:
                return x_[static_cast<std::size_t>(d)][node(i, j + b)];
            case 1:
                return y_[static_cast<std::size_t>(b)][node(i + d, j)];
            default:
                return z_[node(i + b, j + d)];
        }
    }

private:
    std::size_t node(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(field_.nx) + static_cast<std::size_t>(i);
    }

    void make_plane(int k, std::size_t slot) {
        for (int j = 0; j < field_.ny; ++j)
            for (int i = 0; i < field_.nx; ++i) {
                x_[slot][node(i, j)] = i + 1 < field_.nx ? make_vertex(i, j, k, 0) : -1;
                y_[slot][node(i, j)] = j + 1 < field_.ny ? make_vertex(i, j, k, 1) : -1;
            }
    }

    // The vertex on the edge from node (i, j, k) along `axis`, -1 if both ends are on the same side.
    std::int32_t make_vertex(int i, int j, int k, int axis) {
        const std::size_t stride = axis == 0 ? 1 : axis == 1 ? node(0, 1) : node(0, field_.ny);
        const std::size_t from = static_cast<std::size_t>(k) * node(0, field_.ny) + node(i, j);
        const float a = field_.values[from];
        const float b = field_.values[from + stride];
        if ((a < 0.0f) == (b < 0.0f)) return -1;
        // A little away from the ends, so that the vertices of different edges never coincide.
        const double part =
            std::clamp(static_cast<double>(a) / (static_cast<double>(a) - static_cast<double>(b)), 0.01, 0.99);
        Vec3 position_in_grid(i, j, k);
        position_in_grid[axis] += part;
        mesh_.vertices.push_back(field_.origin + field_.spacing * position_in_grid);
        return mesh_.n_vertices() - 1;
    }

    const ScalarField& field_;
    Mesh& mesh_;
    std::array<std::vector<std::int32_t>, 2> x_, y_;  // of the lower and the upper node plane
    std::vector<std::int32_t> z_;
};

// Fills a loop with a disk.
void fill_loop(std::span<const std::int32_t> loop, Mesh& mesh) {
    const std::size_t n = loop.size();
    if (n <= 4) {
        const auto position = [&](std::size_t m) { return mesh.vertices[static_cast<std::size_t>(loop[m % n])]; };
        // Of the two diagonals of a loop of four, the shorter.
        const std::size_t s =
            n == 4 && (position(1) - position(3)).squaredNorm() < (position(0) - position(2)).squaredNorm();
        mesh.triangles.push_back({loop[s], loop[s + 1], loop[s + 2]});
        if (n == 4) mesh.triangles.push_back({loop[s], loop[s + 2], loop[(s + 3) % 4]});
        return;
    }
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t v : loop) sum += mesh.vertices[static_cast<std::size_t>(v)];
    mesh.vertices.push_back(sum / static_cast<double>(n));
    for (std::size_t m = 0; m < n; ++m) mesh.triangles.push_back({loop[m], loop[(m + 1) % n], mesh.n_vertices() - 1});
}

void polygonise_cell(const CornerValues& values, int i, int j, const LayerVertices& vertices, Mesh& mesh) {
    std::array<int, 12> next;
    next.fill(no_edge);
    for (const Face& face : faces) join_face(face, values, next);
    for (int start = 0; start < 12; ++start) {
        std::array<std::int32_t, 12> loop;
        std::size_t n = 0;
        for (int edge = start; next[static_cast<std::size_t>(edge)] != no_edge;) {
            loop[n++] = vertices.at(i, j, edge);
            edge = std::exchange(next[static_cast<std::size_t>(edge)], no_edge);
        }
        if (n > 0) fill_loop({loop.data(), n}, mesh);
    }
}

[[maybe_unused]] bool is_positive_on_border(const ScalarField& field) {
    std::size_t node = 0;
    for (int k = 0; k < field.nz; ++k)
        for (int j = 0; j < field.ny; ++j)
            for (int i = 0; i < field.nx; ++i, ++node) {
                const bool border =
                    i == 0 || j == 0 || k == 0 || i + 1 == field.nx || j + 1 == field.ny || k + 1 == field.nz;
                if (border && !(field.values[node] > 0.0f)) return false;
            }
    return true;
}

}  // namespace

Mesh iso_surface(const ScalarField& field) {
    assert(is_positive_on_border(field));
    Mesh mesh;
    if (field.nx < 2 || field.ny < 2 || field.nz < 2) return mesh;
    const auto row = static_cast<std::size_t>(field.nx);
    const std::size_t plane = row * static_cast<std::size_t>(field.ny);
    LayerVertices vertices(field, mesh);
    for (int k = 0; k + 1 < field.nz; ++k) {
        vertices.enter_layer(k);
        for (int j = 0; j + 1 < field.ny; ++j) {
            const float* lower =
                field.values.data() + static_cast<std::size_t>(k) * plane + static_cast<std::size_t>(j) * row;
            for (int i = 0; i + 1 < field.nx; ++i, ++lower) {
                const float* upper = lower + plane;
                const CornerValues values = {lower[0], lower[1], lower[row], lower[row + 1],
                                             upper[0], upper[1], upper[row], upper[row + 1]};
                const auto n_inside = std::count_if(values.begin(), values.end(), [](float v) { return v < 0.0f; });
                if (n_inside > 0 && n_inside < 8) polygonise_cell(values, i, j, vertices, mesh);
            }
        }
    }
    return mesh;
}

}  // namespace anyrate
