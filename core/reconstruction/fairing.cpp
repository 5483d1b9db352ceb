#include "core/reconstruction/fairing.h"

#include <Eigen/SparseCholesky>
#include <cassert>
#include <cstdint>
#include <vector>

#include "core/reconstruction/surface_view.h"

namespace anyrate {
namespace {

using Row = std::vector<std::pair<std::int32_t, double>>;  // unknown, coefficient

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Normal equations for the places of the flagged vertices.
class PlaceEquations {
public:
    PlaceEquations(const Mesh& mesh, std::span<const char> movable) : mesh_(mesh), unknown_(movable.size(), -1) {
        for (std::int32_t v = 0; v < mesh.n_vertices(); ++v)
            if (movable[at(v)] != 0) {
                unknown_[at(v)] = static_cast<std::int32_t>(vertices_.size());
                vertices_.push_back(v);
            }
        right_ = Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(vertices_.size()), 3);
    }

    bool empty() const { return vertices_.empty(); }

    /// Each flagged vertex stays where it is, by a weight.
    void attach(double weight) {
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            entries_.emplace_back(row, row, weight);
            right_.row(row) += weight * mesh_.vertices[at(vertices_[i])].transpose();
        }
    }

    /// The umbrella of a vertex, the mean of its ring less itself, vanishes.
    void flatten(const OneRings& rings, std::int32_t v) {
        Row row;
        Vec3 fixed = Vec3::Zero();
        const auto add = [&](std::int32_t w, double coefficient) {
            if (unknown_[at(w)] >= 0)
                row.emplace_back(unknown_[at(w)], coefficient);
            else
                fixed += coefficient * mesh_.vertices[at(w)];
        };
        add(v, -1.0);
        for (const std::int32_t w : rings.neighbours(v)) add(w, 1.0 / rings.valence(v));
        for (const auto& [i, a] : row) {
            right_.row(i) -= a * fixed.transpose();
            for (const auto& [j, b] : row) entries_.emplace_back(i, j, a * b);
        }
    }

    void solve_into(Mesh& mesh) const {
        const auto n = static_cast<Eigen::Index>(vertices_.size());
        Eigen::SparseMatrix<double> matrix(n, n);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
        const Eigen::MatrixX3d solution = solver.solve(right_);
        for (Eigen::Index i = 0; i < n; ++i)
            mesh.vertices[at(vertices_[static_cast<std::size_t>(i)])] = solution.row(i).transpose();
    }

private:
    const Mesh& mesh_;
    std::vector<std::int32_t> unknown_, vertices_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::MatrixX3d right_;
};

}  // namespace

void fair(Mesh& mesh, std::span<const char> movable, double attachment) {
    assert(attachment > 0);
    PlaceEquations places(mesh, movable);
    if (places.empty()) return;
    places.attach(attachment);
    const OneRings rings(mesh);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v) {
        bool bends = movable[at(v)] != 0;
        for (const std::int32_t w : rings.neighbours(v)) bends = bends || movable[at(w)] != 0;
        if (bends) places.flatten(rings, v);
    }
    places.solve_into(mesh);
}

void stretch(Mesh& mesh, std::span<const char> movable) {
    constexpr double hardly = 1e-9;  // so that a part without a rim has a place
    PlaceEquations places(mesh, movable);
    if (places.empty()) return;
    places.attach(hardly);
    const OneRings rings(mesh);
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v)
        if (movable[at(v)] != 0) places.flatten(rings, v);
    places.solve_into(mesh);
}

}  // namespace anyrate
