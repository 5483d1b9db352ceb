#include "core/reconstruction/capture_frame.h"

#include <cmath>

namespace anyrate {
namespace {

const double quantum = std::ldexp(1.0, -26);

}  // namespace

Grid CaptureFrame::in_world(const Grid& grid) const {
    Grid result = grid;
    result.origin = origin + unit * grid.origin;
    result.unit = unit * grid.unit;
    return result;
}

CaptureFrame to_own_frame(Capture& capture) {
    const auto n_views = static_cast<double>(capture.views.size());
    CaptureFrame frame;
    // Sums of differences: far from the world's origin those of the positions would lose digits.
    const Vec3 first = capture.views.front().camera.centre();
    Vec3 sum = Vec3::Zero();
    for (const View& view : capture.views) sum += view.camera.centre() - first;
    frame.origin = first + sum / n_views;
    double distances = 0;
    for (const View& view : capture.views) distances += (view.camera.centre() - frame.origin).norm();
    if (distances > 0) frame.unit = distances / n_views;
    for (View& view : capture.views) {
        const Vec3 centre = (view.camera.centre() - frame.origin) / frame.unit / quantum;
        view.camera.t = -view.camera.R * (centre.array().round().matrix() * quantum);
    }
    return frame;
}

}  // namespace anyrate
