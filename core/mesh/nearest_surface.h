#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/float4.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// Answers which point of a triangle mesh is nearest to a given one, exactly: a tree of bounding boxes over a copy of
/// the triangles, four boxes a node, whose single precision only ever makes them larger. Queries may run in parallel.
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
    static constexpr std::size_t width = 4;  ///< of the tree
    /// A place among the triangles stands as ~place among the nodes.
    struct Node {
        Float4 lower[3], upper[3];              ///< of the children, a lane each, from centre_; inverted: no child
        std::array<std::int32_t, width> child;  ///< 0 or more: a node; below: ~place of a triangle
    };
    using Box = Eigen::AlignedBox3d;

    /// Appends the tree over faces face_[begin..end) and orders them by its leaves. @return its box
    Box build(std::span<const Box> boxes, std::int32_t begin, std::int32_t end);
    template <class Accepts>
    Hit search(const Vec3& p, std::int32_t hint, const Accepts& accepts) const;

    Vec3 centre_;                      ///< of the mesh's box
    float slack_ = 0;                  ///< world units: more than what single precision takes from a box
    std::vector<Corners> triangles_;   ///< in the order of the tree's leaves
    std::vector<std::int32_t> face_;   ///< of the mesh, for each of them
    std::vector<std::int32_t> place_;  ///< of each face of the mesh among them
    std::vector<Node> nodes_;
};

}  // namespace anyrate
