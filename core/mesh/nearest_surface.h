#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/mesh.h"

namespace anyrate {

/// Answers which point of a triangle mesh is nearest to a given one, exactly: a tree of bounding boxes over a copy of
/// the triangles. Queries may run in parallel.
class NearestSurface {
public:
    /// @throws InputError if `mesh` has no triangle
    explicit NearestSurface(const Mesh& mesh);

    struct Hit {
        Vec3 point = Vec3::Zero();
        std::int32_t face = -1;  ///< of the mesh; of several equally near ones any, but always the same; -1: none
        double squared_distance = std::numeric_limits<double>::infinity();
    };

    /// @param hint  a face that is probably near (the answer to a neighbour's query), which saves time; -1 for none
    Hit nearest(const Vec3& p, std::int32_t hint = -1) const;

    /// The same among the triangles whose normal is within 90 degrees of `direction`: on a thin part this keeps a point
    /// on its own side. Hit.face is -1 if there is no such triangle.
    Hit nearest_facing(const Vec3& p, const Vec3& direction, std::int32_t hint = -1) const;

    /// Of a face in an order in which those near each other mostly follow each other.
    std::int32_t place(std::int32_t face) const { return place_[static_cast<std::size_t>(face)]; }

private:
    struct Corners {
        Vec3 a, b, c;
    };
    struct Node {
        Eigen::AlignedBox3d box;
        std::int32_t begin = 0, end = 0;  ///< the triangles of a leaf; of an inner node: empty
        std::int32_t right = 0;           ///< an inner node's second child; the first one follows the node
    };

    /// Appends the tree over faces face_[begin..end) and orders them by its leaves.
    void build(const std::vector<Corners>& faces, std::int32_t begin, std::int32_t end);
    template <class Accepts>
    Hit search(const Vec3& p, std::int32_t hint, const Accepts& accepts) const;

    std::vector<Corners> triangles_;   ///< in the order of the tree's leaves
    std::vector<std::int32_t> face_;   ///< of the mesh, for each of them
    std::vector<std::int32_t> place_;  ///< of each face of the mesh among them
    std::vector<Node> nodes_;
};

}  // namespace anyrate
