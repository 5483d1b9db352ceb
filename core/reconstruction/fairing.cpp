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

}  // namespace

void fair(Mesh& mesh, std::span<const char> movable, double attachment) {
    assert(attachment > 0);
    const OneRings rings(mesh);
    std::vector<std::int32_t> unknown(movable.size(), -1), vertices;
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v)
        if (movable[at(v)] != 0) {
            unknown[at(v)] = static_cast<std::int32_t>(vertices.size());
            vertices.push_back(v);
        }
    if (vertices.empty()) return;

    // Normal equations of the umbrellas, each a row of coefficients of the unknowns and what the fixed vertices add.
    const auto n = static_cast<Eigen::Index>(vertices.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixX3d right(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
        entries.emplace_back(i, i, attachment);
        right.row(i) = attachment * mesh.vertices[at(vertices[static_cast<std::size_t>(i)])].transpose();
    }
    const auto add_umbrella = [&](std::int32_t v) {
        Row row;
        Vec3 fixed = Vec3::Zero();
        const auto add = [&](std::int32_t w, double coefficient) {
            if (unknown[at(w)] >= 0)
                row.emplace_back(unknown[at(w)], coefficient);
            else
                fixed += coefficient * mesh.vertices[at(w)];
        };
        add(v, -1.0);
        for (const std::int32_t w : rings.neighbours(v)) add(w, 1.0 / rings.valence(v));
        for (const auto& [i, a] : row) {
            right.row(i) -= a * fixed.transpose();
            for (const auto& [j, b] : row) entries.emplace_back(i, j, a * b);
        }
    };
    for (std::int32_t v = 0; v < mesh.n_vertices(); ++v) {
        bool bends = movable[at(v)] != 0;
        for (const std::int32_t w : rings.neighbours(v)) bends = bends || movable[at(w)] != 0;
        if (bends) add_umbrella(v);
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    const Eigen::MatrixX3d solution = solver.solve(right);
    for (Eigen::Index i = 0; i < n; ++i)
        mesh.vertices[at(vertices[static_cast<std::size_t>(i)])] = solution.row(i).transpose();
}

}  // namespace anyrate
