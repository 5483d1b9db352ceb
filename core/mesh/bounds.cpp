#include "core/mesh/bounds.h"

namespace anyrate {

Eigen::AlignedBox3d bounding_box(const Mesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : mesh.triangles)
        for (const auto v : t) box.extend(mesh.vertices[v]);
    return box;
}

bool floats_suffice(const Mesh& mesh) {
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    if (box.isEmpty()) return true;
    const double bound = 1e-6 * box.diagonal().norm();
    for (const Vec3& v : mesh.vertices)
        if ((v.cast<float>().cast<double>() - v).cwiseAbs().maxCoeff() > bound) return false;
    return true;
}

}  // namespace anyrate
