#include "core/encoding/closed_surface.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/mesh/topology.h"

namespace anyrate {
namespace {

void refuse_if_any(const std::string& name, int count, const std::string& what) {
    if (count > 0)
        throw InputError(name + ": expected a closed manifold surface, found " + std::to_string(count) + what);
}

}  // namespace

void require_closed_surface(const Mesh& mesh, const std::string& name) {
    if (mesh.triangles.empty()) throw InputError(name + ": expected triangles, found none");
    const auto bad = std::ranges::find_if(mesh.vertices, [](const Vec3& v) { return !v.allFinite(); });
    if (bad != mesh.vertices.end())
        throw InputError(name + ": vertex " + std::to_string(bad - mesh.vertices.begin()) +
                         " has no finite coordinates");
    const Topology topology = measure_topology(mesh);
    refuse_if_any(name, topology.n_nonmanifold_edges, " edges of more than two faces");
    refuse_if_any(name, topology.n_boundary_edges, " edges of one face: it is not closed");
    refuse_if_any(name, topology.n_inconsistent_edges, " edges whose two faces are not oriented alike");
    refuse_if_any(name, topology.n_nonmanifold_vertices,
                  " vertices without a face, or whose faces form more than one fan");
    if (topology.n_components != 1)
        throw InputError(name + ": expected one piece, found " + std::to_string(topology.n_components));
}

}  // namespace anyrate
