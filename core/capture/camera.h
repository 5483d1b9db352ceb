#pragma once
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/types.h"

namespace anyrate {

/// A calibrated pinhole camera: x ~ K (R X + t).
///
/// Conventions, shared by everything that touches a pixel:
/// - camera axes as in OpenCV: x right, y down, z forward; det R = +1; what is seen has positive depth;
/// - inside this program the CENTRE of the top-left pixel is at (0, 0), so integer coordinates are pixel
///   centres and the image covers [-0.5, width - 0.5] x [-0.5, height - 0.5]. The loader moves the principal
///   point of a capture with another `pixel_center`;
/// - K is upper triangular with K(2,2) = 1; skew and any principal point are allowed; no lens distortion is
///   left (the loader undistorts the images).
struct Camera {
    Mat3 K = Mat3::Identity();
    Mat3 R = Mat3::Identity();  ///< cam_from_world rotation
    Vec3 t = Vec3::Zero();      ///< cam_from_world translation, world units
    int width = 0, height = 0;  ///< pixels

    Vec3 cam_from_world(const Vec3& point_in_world) const { return R * point_in_world + t; }
    /// Pixel position of a world point; its depth must be positive.
    Vec2 project(const Vec3& point_in_world) const { return (K * cam_from_world(point_in_world)).hnormalized(); }
    /// Centre of projection in world coordinates.
    Vec3 centre() const { return -R.transpose() * t; }
    /// The 3x4 projection matrix P = K [R | t] of the paper.
    Mat34 P() const {
        Mat34 P;
        P << K * R, K * t;
        return P;
    }
};

/// The projection matrix of the same view when what stood at pixel x stands at x + by.
inline Mat34 with_moved_pixels(const Mat34& P, const Vec2& by) {
    Mat34 moved = P;
    moved.topRows<2>() += by * P.row(2);
    return moved;
}

}  // namespace anyrate
