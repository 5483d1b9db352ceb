#include "core/reconstruction/initial_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mesh/topology.h"
#include "core/reconstruction/confirmed_depth.h"
#include "core/reconstruction/depth_votes.h"
#include "core/reconstruction/fairing.h"
#include "core/reconstruction/iso_surface.h"
#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/poisson.h"
#include "core/reconstruction/seen_through.h"
#include "core/reconstruction/unseen_surface.h"

namespace anyrate {
namespace {

// Half as much again as the hull's cells, as long as memory for the grid stays in bounds: three floats a node, and a
// seventh of it for the coarser grids. Measured against the hull's own: the final errors of nefertiti, pot and bowl are
// the same within 3 %, oxford_dinosaur keeps its fingers and loses false handles, and all until the coarse mesh takes
// 2 s less (bowl).
double poisson_spacing(const VisualHull& hull) {
    constexpr double hull_cells = 1.5;
    constexpr double most_nodes = 256.0 * 256.0 * 256.0;
    const Vec3 nodes = (hull.upper - hull.lower) / hull.cell;
    return hull.cell * std::max(hull_cells, std::cbrt((nodes.array() + 16.0).prod() / most_nodes));
}

// So near the hull the photographs decide: the optimiser gets there from it, as it does where nothing is seen through.
constexpr double hull_reach_cells = 12.0;

// How far a point of a guessed part speaks for the surface around it.
constexpr double reach_cells = 3.0;

// Around a handle that noise of the masks makes it is a few cells, around a tunnel that false depths dig through a thin
// wall some more (a bowl from every second view: two are left of four with 8); around a handle of the object that the
// images resolve, more than these.
constexpr double handle_loop_cells = 12.0;

/// The surface through the hull's points that no views see through, and out of the space that depths show free.
ScalarField carved_field(const VisualHull& hull, std::span<const DepthMap> confirmed, double spacing) {
    const auto votes = [&](const NodeRow& row, RowVotes& of_row) { depth_votes(confirmed, row, of_row); };
    return poisson_field(without_seen_through(hull.points, confirmed), {.spacing = spacing}, votes);
}

}  // namespace

HullOptions hull_options(const PhotoImages& images) { return {.pixels_per_cell = std::exp2(swept_level(images))}; }

InitialSurface initial_surface(const VisualHull& hull, const PhotoImages& images, const ProgressFn& progress) {
    const auto report = [&](Stage stage, double fraction) {
        if (progress) progress({stage, fraction, 0, 0.0});
    };
    report(Stage::hull, 0.5);
    const ConfirmedDepths depths = confirm_depths(plane_sweep(images, hull));
    report(Stage::hull, 1.0);

    report(Stage::poisson, 0.0);
    const double spacing = poisson_spacing(hull);
    InitialSurface initial;
    initial.mesh = largest_component(iso_surface(carved_field(hull, depths.confirmed, spacing)));
    report(Stage::poisson, 0.5);
    initial.mesh = remove_small_handles(initial.mesh, handle_loop_cells * spacing);
    const std::vector<char> unseen = unseen_vertices(initial.mesh, images);
    stretch(initial.mesh, unseen);
    const std::vector<OrientedPoint> seen = without_unseen(hull.points, images);
    initial.guessed = GuessedSurface(guessed_points(initial.mesh, unseen, {hull.points, seen}, depths.found,
                                                    {.reach = hull_reach_cells * hull.cell}),
                                     reach_cells * spacing);
    report(Stage::poisson, 1.0);
    return initial;
}

}  // namespace anyrate
