#include "core/mesh/coarse_fit.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/mesh/decimate.h"
#include "core/mesh/normal_fit.h"
#include "core/mesh/remesh.h"

namespace anyrate {

namespace {

constexpr double step_down = 0.85;  ///< vertices of a stage, in parts of the one before; 0.7: +3 %, 0.92: no gain
constexpr double first_stage = 2;  ///< in parts of the coarse mesh; with 3 a spot of a pot is 1.3 % of the diagonal off
constexpr double most_of_an_edge = 0.25;  ///< with 0.5 the lip of a pot turns over: 8 % worse at all later counts

void fit_all(Mesh& mesh, SurfaceMeter& meter, const FitOptions& options) {
    std::vector<std::int32_t> all(mesh.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    fit_along_normals(mesh, all, meter, options);
}

/// The surface simplified to not much more than a count, in stages that are each fitted to it: quadrics know but the
/// planes of the mesh that they simplify, with all its noise; fitted vertices average over it. Against one stage a
/// reconstruction's base errs 5 to 9 % less, that of a scan 20 to 25 %.
Mesh stages_above(const Mesh& mesh, int n_vertices, SurfaceMeter& meter) {
    std::vector<int> counts;
    for (double n = n_vertices / step_down; n < std::min<double>(mesh.n_vertices(), first_stage * n_vertices);
         n /= step_down)
        counts.push_back(static_cast<int>(n));
    Mesh stage = mesh;
    for (; !counts.empty(); counts.pop_back()) {
        stage = decimate(stage, counts.back());
        fit_all(stage, meter, {.most_edges = most_of_an_edge});
    }
    return stage;
}

}  // namespace

Mesh fit_coarse_mesh(const Mesh& mesh, int n_vertices, SurfaceMeter& meter) {
    // Simplified, not remeshed to equal edges: a bust of 35,002 vertices at 2,500 is 0.018 % of its diagonal off then,
    // 0.036 % otherwise.
    Mesh base = decimate(stages_above(mesh, n_vertices, meter), n_vertices);
    if (base.n_vertices() > n_vertices) base = remesh_isotropic(mesh, {.n_vertices = n_vertices});
    fit_all(base, meter, {.rounds = 3, .most_edges = most_of_an_edge});
    return base;
}

}  // namespace anyrate
