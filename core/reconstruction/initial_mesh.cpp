#include "core/reconstruction/initial_mesh.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/topology.h"
#include "core/reconstruction/confirmed_depth.h"
#include "core/reconstruction/iso_surface.h"
#include "core/reconstruction/open_cavities.h"
#include "core/reconstruction/plane_sweep.h"
#include "core/reconstruction/poisson.h"
#include "core/reconstruction/visual_hull.h"

namespace anyrate {
namespace {

// As fine as the hull, as long as memory for the grid stays in bounds: three floats a node, and a seventh of it for the
// coarser grids. Measured: cells of 2 pixels give the same distance to the ground truth as 1.5 (nefertiti, 0.140 % of
// the diagonal) in half the time, and keep the fingers of oxford_dinosaur.
double poisson_spacing(const VisualHull& hull) {
    constexpr double most_nodes = 256.0 * 256.0 * 256.0;
    const Vec3 nodes = (hull.upper - hull.lower) / hull.cell;
    return hull.cell * std::max(1.0, std::cbrt((nodes.array() + 16.0).prod() / most_nodes));
}

// Around a handle that noise of the masks makes it is a few cells; around one of the object that the images resolve,
// more.
constexpr double handle_loop_cells = 8.0;

}  // namespace

Mesh initial_surface(const Capture& capture, const PhotoImages& images, const ProgressFn& progress) {
    const auto report = [&](Stage stage, double fraction) {
        if (progress) progress({stage, fraction, 0, 0.0});
    };
    report(Stage::hull, 0.0);
    const VisualHull hull = visual_hull(capture);
    report(Stage::hull, 0.5);
    const auto points = open_cavities(hull, confirm_depths(plane_sweep(images, hull)));
    report(Stage::hull, 1.0);

    report(Stage::poisson, 0.0);
    const double spacing = poisson_spacing(hull);
    const ScalarField field = poisson_field(points, {.spacing = spacing});
    report(Stage::poisson, 0.5);
    const Mesh surface = largest_component(iso_surface(field));
    Mesh clean = remove_small_handles(surface, handle_loop_cells * spacing);
    report(Stage::poisson, 1.0);
    return clean;
}

}  // namespace anyrate
