#include "core/mesh/coarse_fit.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/mesh/decimate.h"
#include "core/mesh/decimate_apart.h"
#include "core/mesh/keep_apart.h"
#include "core/mesh/remesh.h"
#include "core/mesh/vertex_fit.h"

namespace anyrate {

namespace {

constexpr double step_down = 0.85;  ///< vertices of a stage, in parts of the one before; 0.7: +3 %, 0.92: no gain
constexpr double first_stage = 2;  ///< in parts of the coarse mesh; with 3 a spot of a pot is 1.3 % of the diagonal off
constexpr int base_rounds = 4;     ///< 3: up to 1 % worse at 2,500; 5 gain nothing
constexpr double most_of_an_edge = 0.25;  ///< with 0.5 the lip of a pot turns over: 8 % worse at all later counts

/// Moves all vertices in their tangent planes and along their normals. What a quadric knows of where a vertex should be
/// is what its own faces were; where the surface is fitted best with all the others in their places, it does not: at
/// 2,500 vertices a reconstructed pot errs 20 % less than with moves along normals alone, a bust 8 %.
void fit_all(Mesh& mesh, SurfaceMeter& meter, bool may_meet) {
    std::vector<std::int32_t> all(mesh.vertices.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<Vec3> before(mesh.vertices);
    fit_vertices(mesh, all, meter, {.slides = true, .most_edges = most_of_an_edge});
    if (!may_meet) keep_apart(mesh, before);
}

/// How many vertices the surface is simplified to on the way to a count, that count left out: quadrics know but the
/// planes of the mesh that they simplify, with all its noise; vertices that are fitted after each stage average over
/// it. Against one stage a reconstruction's base errs 5 to 9 % less, that of a scan 20 to 25 %.
/// @return ascending; the last one is the first stage
std::vector<int> stages_above(int n_vertices, int n_in_mesh) {
    std::vector<int> counts;
    for (double n = n_vertices / step_down; n < std::min<double>(n_in_mesh, first_stage * n_vertices); n /= step_down)
        counts.push_back(static_cast<int>(n));
    return counts;
}

Mesh simplify(const Mesh& mesh, int n_vertices, bool may_meet) {
    return may_meet ? decimate(mesh, n_vertices) : decimate_apart(mesh, n_vertices);
}

}  // namespace

Mesh first_coarse_stage(const Mesh& mesh, int n_vertices, bool may_meet) {
    const std::vector<int> counts = stages_above(n_vertices, mesh.n_vertices());
    return counts.empty() ? mesh : simplify(mesh, counts.back(), may_meet);
}

Mesh fit_coarse_mesh(const Mesh& mesh, Mesh stage, int n_vertices, SurfaceMeter& meter, bool may_meet) {
    for (std::vector<int> counts = stages_above(n_vertices, mesh.n_vertices()); !counts.empty();) {
        fit_all(stage, meter, may_meet);
        counts.pop_back();
        if (!counts.empty()) stage = simplify(stage, counts.back(), may_meet);
    }
    // Simplified, not remeshed to equal edges: a bust of 35,002 vertices at 2,500 is 0.018 % of its diagonal off then,
    // 0.036 % otherwise.
    Mesh base = simplify(stage, n_vertices, may_meet);
    if (base.n_vertices() > n_vertices) base = remesh_isotropic(mesh, {.n_vertices = n_vertices});
    for (int round = 0; round < base_rounds; ++round) fit_all(base, meter, may_meet);
    return base;
}

Mesh fit_coarse_mesh(const Mesh& mesh, int n_vertices, SurfaceMeter& meter, bool may_meet) {
    return fit_coarse_mesh(mesh, first_coarse_stage(mesh, n_vertices, may_meet), n_vertices, meter, may_meet);
}

}  // namespace anyrate
