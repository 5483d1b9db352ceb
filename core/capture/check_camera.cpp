#include "core/capture/check_camera.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace anyrate {
namespace {

/// Largest entry of R R^T - I that still passes: twice what six digits after the point leave, and a margin.
constexpr double rotation_tolerance = 1e-5;

std::string text_of(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

std::optional<Mat3> checked_K(const CameraEntry& entry, Faults& faults) {
    if (!entry.K) return std::nullopt;
    Mat3 K = *entry.K;
    const double below = std::max({std::abs(K(1, 0)), std::abs(K(2, 0)), std::abs(K(2, 1))});
    if (below > 1e-9 * K.cwiseAbs().maxCoeff()) {
        faults.add(entry.file, "K is not upper triangular, " + text_of(below) +
                                   " stands below the diagonal; expected [[fx, skew, cx], [0, fy, cy], [0, 0, 1]]");
        return std::nullopt;
    }
    K /= K(2, 2);
    K.row(2) = Vec3::UnitZ().transpose();
    K(1, 0) = 0.0;
    if (!K.allFinite() || K(0, 0) == 0.0 || K(1, 1) == 0.0) {
        faults.add(entry.file, "K is singular, its diagonal is " + text_of((*entry.K)(0, 0)) + ", " +
                                   text_of((*entry.K)(1, 1)) + ", " + text_of((*entry.K)(2, 2)) +
                                   "; expected focal lengths in pixels and 1");
        return std::nullopt;
    }
    if (K(0, 0) < 0.0 || K(1, 1) < 0.0) {
        faults.add(entry.file, "the focal lengths in K are " + text_of(K(0, 0)) + " and " + text_of(K(1, 1)) +
                                   "; expected positive ones (camera axes x right, y down, z forward)");
        return std::nullopt;
    }
    return K;
}

std::optional<Mat3> checked_R(const CameraEntry& entry, Faults& faults) {
    if (!entry.R) return std::nullopt;
    const Mat3& R = *entry.R;
    const double error = (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
    if (!(error <= rotation_tolerance)) {
        faults.add(entry.file, "R is not a rotation, R R^T differs from the identity by " + text_of(error) +
                                   "; expected at most " + text_of(rotation_tolerance));
        return std::nullopt;
    }
    if (R.determinant() < 0.0) {
        faults.add(entry.file, "R is a reflection, its determinant is -1; expected a rotation, +1");
        return std::nullopt;
    }
    if (error < 1e-12) return R;
    const Eigen::JacobiSVD<Mat3> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return Mat3(svd.matrixU() * svd.matrixV().transpose());
}

}  // namespace

std::optional<Camera> to_camera(const CameraEntry& entry, const Vec2& pixel_center, Faults& faults) {
    const auto K = checked_K(entry, faults);
    const auto R = checked_R(entry, faults);
    if (!K || !R || !entry.t) return std::nullopt;
    Camera camera;
    camera.K = *K;
    camera.K.block<2, 1>(0, 2) -= pixel_center;
    camera.R = *R;
    camera.t = *entry.t;
    return camera;
}

void check_baseline(const std::vector<Camera>& cameras, const std::string& cameras_file, Faults& faults) {
    if (cameras.size() < 2) return;
    const Vec3 first = cameras.front().centre();
    double spread = 0.0, size = 0.0;
    for (const Camera& camera : cameras) {
        spread = std::max(spread, (camera.centre() - first).norm());
        size = std::max(size, camera.centre().norm());
    }
    if (spread <= 1e-9 * size)
        faults.add(cameras_file, "all " + std::to_string(cameras.size()) +
                                     " cameras stand at one place; expected views from different places");
}

}  // namespace anyrate
