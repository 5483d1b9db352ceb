#include "core/encoding/closed_surface.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/mesh/topology.h"

namespace anyrate {
namespace {

void refuse_if_any(int count, const std::string& what) {
    if (count > 0) throw InputError("mesh: expected a closed manifold surface, found " + std::to_string(count) + what);
}

}  // namespace

void require_closed_surface(const Mesh& mesh) {
    if (mesh.triangles.empty()) throw InputError("mesh: expected triangles, found none");
    const auto bad = std::ranges::find_if(mesh.vertices, [](const Vec3& v) { return !v.allFinite(); });
    if (bad != mesh.vertices.end())
        throw InputError("mesh: vertex " + std::to_string(bad - mesh.vertices.begin()) + " has no finite coordinates");
    const Topology topology = measure_topology(mesh);
    refuse_if_any(topology.n_nonmanifold_edges, " edges of more than two faces");
    refuse_if_any(topology.n_boundary_edges, " edges of one face: it is not closed");
    refuse_if_any(topology.n_inconsistent_edges, " edges whose two faces are not oriented alike");
    refuse_if_any(topology.n_nonmanifold_vertices, " vertices without a face, or whose faces form more than one fan");
    if (topology.n_components != 1)
        throw InputError("mesh: expected one piece, found " + std::to_string(topology.n_components));
}

}  // namespace anyrate
