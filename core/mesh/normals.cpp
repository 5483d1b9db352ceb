#include "core/mesh/normals.h"

#include <Eigen/Geometry>

namespace anyrate {

std::vector<Vec3> vertex_normals(const Mesh& mesh) {
    std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3& p = mesh.vertices[a];
        const Vec3 twice_area = (mesh.vertices[b] - p).cross(mesh.vertices[c] - p);
        for (const auto v : {a, b, c}) normals[v] += twice_area;
    }
    for (Vec3& n : normals) n.stableNormalize();
    return normals;
}

}  // namespace anyrate
