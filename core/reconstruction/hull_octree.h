#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "core/reconstruction/hull_witnesses.h"

namespace anyrate {

/// Of an octree's level, cells counted from its cube's lower corner along each axis.
using Cell = std::array<std::int32_t, 3>;

/// A cube of 2^depth cells an axis.
struct Cube {
    Vec3 lower;
    double edge = 0.0;
    Vec3 centre() const { return lower.array() + 0.5 * edge; }
};

/// What the views show in a cell: in one of `mixed`, to be looked at in its parts, both object and background; in one
/// of `object` nothing but that; others say nothing about it.
template <class Set>
struct Shown {
    Set mixed, object;
};

/// Cells of one level that the hull's boundary may pass, and what the views show in each.
struct BoundaryCells {
    std::vector<Cell> cells;
    Shown<ViewSets> shown;
};

struct Carved {
    BoundaryCells boundary;      // of the last level
    Eigen::AlignedBox3d inside;  // box of the cells of all levels that lie inside
};

/// The visual hull on an octree, level by level: only the cells of the current level are held. A cell asks only the
/// views that showed its parent both object and background.
/// @param cube   world units
/// @param depth  levels, 1 or more: cells of the last have an edge of cube.edge / 2^depth
Carved carve(const Cones& cones, const Cube& cube, int depth);

}  // namespace anyrate
