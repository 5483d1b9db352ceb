#pragma once
#include <Eigen/Geometry>

#include "core/mesh/mesh.h"

namespace anyrate {

/// The smallest box along the axes around the vertices that triangles use; empty without triangles.
Eigen::AlignedBox3d bounding_box(const Mesh& mesh);

/// Whether positions as 32-bit floats stay within a millionth of the bounding box's diagonal: not so for an object of
/// a metre in coordinates of a country.
bool floats_suffice(const Mesh& mesh);

}  // namespace anyrate
