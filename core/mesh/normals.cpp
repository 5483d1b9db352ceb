#include "core/mesh/normals.h"

#include <Eigen/Geometry>
#include <cmath>

namespace anyrate {

std::vector<Vec3> vertex_normals(const Mesh& mesh) {
    std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3& p = mesh.vertices[a];
        const Vec3 twice_area = (mesh.vertices[b] - p).cross(mesh.vertices[c] - p);
        for (const auto v : {a, b, c}) normals[v] += twice_area;
    }
    for (Vec3& n : normals) n.normalize();
    return normals;
}

std::vector<Eigen::Vector3f> file_normals(const Mesh& mesh) {
    std::vector<Eigen::Vector3f> normals;
    normals.reserve(mesh.vertices.size());
    for (const Vec3& n : vertex_normals(mesh)) {
        const bool is_unit = std::abs(n.norm() - 1) < 1e-6;  // not if it is no number
        normals.push_back(is_unit ? Eigen::Vector3f(n.cast<float>()) : Eigen::Vector3f::UnitZ());
    }
    return normals;
}

}  // namespace anyrate
