#include "core/mesh/decimate.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "core/error.h"
#include "core/mesh/bounds.h"
#include "core/mesh/surface.h"
#include "core/mesh/topology.h"

namespace anyrate {

Mesh decimate(const Mesh& mesh, int n_vertices) { return decimate_keeping(mesh, n_vertices, {}).mesh; }

Decimated decimate_keeping(const Mesh& mesh, int n_vertices, std::span<const char> is_kept) {
    if (!measure_topology(mesh).is_closed_manifold()) throw InputError("decimate: expected a closed manifold");
    // Quadrics square the coordinates, and OpenMesh compares their errors as floats: work near the origin, in unit
    // size.
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    const Vec3 centre = box.center();
    const double size = box.diagonal().norm();
    Mesh unit{.vertices = mesh.vertices, .triangles = mesh.triangles, .colours = {}};
    for (Vec3& v : unit.vertices) v = (v - centre) / size;
    Surface surface = to_surface(unit);
    surface.request_face_normals();
    surface.update_face_normals();
    OpenMesh::VPropHandleT<std::int32_t> source;
    surface.add_property(source);
    for (const auto v : surface.vertices()) {
        surface.property(source, v) = v.idx();
        if (!is_kept.empty()) surface.status(v).set_locked(is_kept[static_cast<std::size_t>(v.idx())] != 0);
    }
    OpenMesh::Decimater::DecimaterT<Surface> decimater(surface);
    OpenMesh::Decimater::ModQuadricT<Surface>::Handle quadric;
    OpenMesh::Decimater::ModNormalFlippingT<Surface>::Handle no_flip;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    decimater.add(no_flip);
    decimater.module(no_flip).set_max_normal_deviation(75);
    decimater.initialize();
    decimater.decimate_to(static_cast<std::size_t>(n_vertices));
    surface.garbage_collection();
    Decimated coarse{to_mesh(surface), {}};
    for (Vec3& v : coarse.mesh.vertices) v = v * size + centre;
    for (const auto v : surface.vertices()) coarse.sources.push_back(surface.property(source, v));
    return coarse;
}

}  // namespace anyrate
