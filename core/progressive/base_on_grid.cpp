#include "core/progressive/base_on_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "core/mesh/triangle_shape.h"

namespace anyrate {
namespace {

constexpr double grid_margin = 0.04;      ///< of the largest extent, kept free on each side
constexpr double fewest_per_edge = 18;    ///< base positions along an edge of mean length
constexpr int reach = 2;                  ///< cells from the nearest position, along each axis, that are looked at
constexpr double slide_price = 0.005;     ///< of a squared way along the surface, in parts of one off it
constexpr double least_turned_cos = 0.5;  ///< between a face's normals before and after

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

using Cell = Eigen::Vector3i;

/// The positions that a base may have, as whole numbers of cells in [0, size).
class BaseLattice {
public:
    explicit BaseLattice(const Grid& grid)
        : grid_(grid), size_(1 << (grid.bits - grid.base_shift)), cell_(std::ldexp(grid.unit, grid.base_shift)) {}

    /// In cells, no whole number yet.
    Vec3 place(const Vec3& world) const { return (world - grid_.origin) / cell_; }
    Cell nearest(const Vec3& place) const {
        const auto snap = [&](double x) { return std::clamp(static_cast<int>(std::lround(x)), 0, size_ - 1); };
        return {snap(place.x()), snap(place.y()), snap(place.z())};
    }
    bool holds(const Cell& cell) const { return cell.minCoeff() >= 0 && cell.maxCoeff() < size_; }
    GridPoint on_grid(const Cell& cell) const {
        return {cell.x() << grid_.base_shift, cell.y() << grid_.base_shift, cell.z() << grid_.base_shift};
    }

private:
    Grid grid_;
    int size_;
    double cell_;
};

/// Puts one vertex after the other onto the lattice. Lengths are in cells.
class LatticeFit {
public:
    LatticeFit(const Mesh& mesh, const BaseLattice& lattice)
        : lattice_(lattice), triangles_(mesh.triangles), faces_(mesh.vertices.size()) {
        for (const Vec3& v : mesh.vertices) places_.push_back(lattice.place(v));
        for (const Triangle& t : triangles_) {
            for (const std::int32_t v : t) faces_[at(v)].push_back(normals_.size());
            normals_.push_back(twice_area_vector(places_[at(t[0])], places_[at(t[1])], places_[at(t[2])]));
        }
    }

    Cell put(std::size_t vertex) {
        const Vec3 place = places_[vertex];
        const Cell middle = lattice_.nearest(place);
        const Mat3 cost = cost_of(vertex);
        std::vector<Candidate> candidates;
        for (int x = -reach; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y)
                for (int z = -reach; z <= reach; ++z) {
                    const Cell cell = middle + Cell(x, y, z);
                    const Vec3 way = cell.cast<double>() - place;
                    if (lattice_.holds(cell)) candidates.push_back({way.dot(cost * way), cell});
                }
        std::ranges::stable_sort(candidates, {}, &Candidate::cost);
        for (const Candidate& candidate : candidates) {
            places_[vertex] = candidate.cell.cast<double>();
            if (!turns_a_face(vertex)) return candidate.cell;
        }
        places_[vertex] = middle.cast<double>();
        return middle;
    }

private:
    struct Candidate {
        double cost;
        Cell cell;
    };

    /// Of a way from the vertex: squared distance to the planes of its faces, weighted by area, and a little for the
    /// way itself (Garland and Heckbert 1997, "Surface Simplification Using Quadric Error Metrics").
    Mat3 cost_of(std::size_t vertex) const {
        Mat3 quadric = Mat3::Zero();
        double area = 0;
        for (const std::size_t f : faces_[vertex]) {
            const double twice_area = normals_[f].norm();
            if (twice_area > 0) quadric += normals_[f] * normals_[f].transpose() / twice_area;
            area += twice_area;
        }
        return quadric + std::max(slide_price * area, 1e-12) * Mat3::Identity();
    }

    bool turns_a_face(std::size_t vertex) const {
        return std::ranges::any_of(faces_[vertex], [&](std::size_t f) {
            const Triangle& t = triangles_[f];
            const Vec3 now = twice_area_vector(places_[at(t[0])], places_[at(t[1])], places_[at(t[2])]);
            return !(now.dot(normals_[f]) > least_turned_cos * now.norm() * normals_[f].norm());
        });
    }

    const BaseLattice& lattice_;
    std::span<const Triangle> triangles_;
    std::vector<std::vector<std::size_t>> faces_;  ///< around each vertex
    std::vector<Vec3> places_;                     ///< of the vertices that were put: where they are now
    std::vector<Vec3> normals_;                    ///< of the faces as they were, twice their areas long
};

double mean_edge(const Mesh& mesh) {
    double twice_area = 0;
    for (const Triangle& t : mesh.triangles)
        twice_area +=
            twice_area_vector(mesh.vertices[at(t[0])], mesh.vertices[at(t[1])], mesh.vertices[at(t[2])]).norm();
    return mesh.triangles.empty() ? 0 : std::sqrt(2 / std::numbers::sqrt3 * twice_area / mesh.n_faces());
}

}  // namespace

Grid make_grid(const Mesh& mesh, int n_vertices) {
    Vec3 lower = mesh.vertices.front(), upper = lower;
    for (const Vec3& v : mesh.vertices) {
        lower = lower.cwiseMin(v);
        upper = upper.cwiseMax(v);
    }
    const double extent = (upper - lower).maxCoeff();
    Grid grid;
    grid.bits = n_vertices > 50'000 ? 16 : 14;
    grid.unit = extent * (1 + 2 * grid_margin) / (std::ldexp(1.0, grid.bits) - 1);
    grid.origin = lower - Vec3::Constant(grid_margin * extent);
    grid.base_shift = base_shift(mesh, grid);
    return grid;
}

int base_shift(const Mesh& base, const Grid& grid) {
    const double edge = mean_edge(base) / grid.unit;
    int shift = 0;
    while (shift < grid.bits - 1 && std::ldexp(fewest_per_edge, shift + 1) <= edge) ++shift;
    return shift;
}

BaseMesh to_base(const Mesh& mesh, const Grid& grid) {
    const BaseLattice lattice(grid);
    LatticeFit fit(mesh, lattice);
    BaseMesh base{{}, mesh.triangles};
    base.positions.reserve(mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) base.positions.push_back(lattice.on_grid(fit.put(v)));
    return base;
}

BaseMesh nearest_base(const Mesh& mesh, const Grid& grid) {
    const BaseLattice lattice(grid);
    BaseMesh base{{}, mesh.triangles};
    base.positions.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) base.positions.push_back(lattice.on_grid(lattice.nearest(lattice.place(v))));
    return base;
}

}  // namespace anyrate
