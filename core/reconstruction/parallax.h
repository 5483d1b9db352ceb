#pragma once
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/types.h"

namespace anyrate {

/// How the pixels of one view move in another as their depth changes: x_other ~ A x + b / depth, both homogeneous,
/// with the depth along the first view's optical axis.
struct Parallax {
    Mat3 A = Mat3::Identity();
    Vec3 b = Vec3::Zero();
};

/// @param P, Q    project to the pixels of the first view and of the other
/// @param centre  of the first's projection
inline Parallax parallax_between(const Mat34& P, const Vec3& centre, const Mat34& Q) {
    return {Q.leftCols<3>() * P.leftCols<3>().inverse(), Q * centre.homogeneous()};
}

}  // namespace anyrate
