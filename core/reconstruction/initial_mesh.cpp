#include "core/reconstruction/initial_mesh.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/topology.h"
#include "core/reconstruction/iso_surface.h"
#include "core/reconstruction/poisson.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {
namespace {

// As fine as the hull, as long as memory for the grid stays in bounds: three floats a node, and an eighth of it for
// the coarser grids.
double poisson_spacing(const VisualHull& hull, double cells) {
    constexpr double most_nodes = 256.0 * 256.0 * 256.0;
    const Vec3 nodes = (hull.upper - hull.lower) / (cells * hull.cell);
    return cells * hull.cell * std::max(1.0, std::cbrt((nodes.array() + 20.0).prod() / most_nodes));
}

}  // namespace

Mesh initial_surface(const Capture& capture, const ProgressFn& progress) {
    const auto report = [&](Stage stage, double fraction) {
        if (progress) progress({stage, fraction, 0, 0.0});
    };
    report(Stage::hull, 0.0);
    const VisualHull hull = visual_hull(capture);
    report(Stage::hull, 1.0);

    report(Stage::poisson, 0.0);
    const double spacing = poisson_spacing(hull, 1.0);
    const ScalarField field = poisson_field(hull.points, {.spacing = spacing});
    report(Stage::poisson, 0.5);
    const Mesh surface = largest_component(iso_surface(field));
    // A handle that noise of the masks makes is a few cells around; a gap of the object that the images resolve is
    // more.
    constexpr double handle_loop_cells = 8.0;
    Mesh clean = remove_small_handles(surface, handle_loop_cells * spacing);
    report(Stage::poisson, 1.0);
    return clean;
}

}  // namespace anyrate
