#include "core/capture/object_position.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <sstream>
#include <vector>

namespace anyrate {
namespace {

/// What a mask says about where the object is: it projects into a box, and about the line through its centroid.
struct Sighting {
    const View* view;
    Vec2 box_min, box_max;   // pixels; a side at the image's border is open, there the object may go on
    Vec3 centre, direction;  // world; a unit vector
};

Sighting sight(const View& view) {
    const MaskImage& mask = view.mask;
    Vec2 low(mask.width, mask.height), high(-1, -1), sum(0, 0);
    double n_pixels = 0;
    for (int y = 0; y < mask.height; ++y) {
        for (int x = 0; x < mask.width; ++x) {
            if (mask(x, y) == 0) continue;
            low = low.cwiseMin(Vec2(x, y));
            high = high.cwiseMax(Vec2(x, y));
            sum += Vec2(x, y);
            ++n_pixels;
        }
    }
    // A quarter of the object's size and two pixels are forgiven: this looks for blunders, not for inaccuracy.
    const Vec2 margin = 0.25 * (high - low) + Vec2(2, 2);
    const Vec2 last(mask.width - 1, mask.height - 1);
    Sighting result{&view, low - margin, high + margin, view.camera.centre(), {}};
    for (int axis = 0; axis < 2; ++axis) {
        if (low[axis] == 0) result.box_min[axis] = -std::numeric_limits<double>::infinity();
        if (high[axis] == last[axis]) result.box_max[axis] = std::numeric_limits<double>::infinity();
    }
    const Vec3 aim = (sum / n_pixels).homogeneous();
    result.direction = (view.camera.R.transpose() * (view.camera.K.inverse() * aim)).normalized();
    return result;
}

double depth(const Sighting& s, const Vec3& point) { return s.view->camera.cam_from_world(point).z(); }

/// Whether the point, in front of the camera or behind it, lies on a line of sight through the box.
bool supports(const Sighting& s, const Vec3& point) {
    const Vec2 pixel = s.view->camera.project(point);
    return (pixel.array() >= s.box_min.array()).all() && (pixel.array() <= s.box_max.array()).all();
}

/// The point nearest to the sightings' lines, least squares; nullopt if the lines are parallel.
std::optional<Vec3> meeting_point(std::span<const Sighting> sightings) {
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    const Vec3 origin = sightings.front().centre;  // keeps a far away world origin out of the sums
    for (const Sighting& s : sightings) {
        const Mat3 across = Mat3::Identity() - s.direction * s.direction.transpose();
        A += across;
        b += across * (s.centre - origin);
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(A);
    if (!(eigen.eigenvalues()[0] > 1e-9 * eigen.eigenvalues()[2])) return std::nullopt;
    return origin + A.ldlt().solve(b);
}

struct Place {
    Vec3 point;
    std::size_t n_supports = 0, n_in_front = 0;

    bool is_better_than(const Place& other) const {
        return n_supports != other.n_supports ? n_supports > other.n_supports : n_in_front > other.n_in_front;
    }
};

Place weigh(const Vec3& point, std::span<const Sighting> sightings) {
    Place place{point};
    for (const Sighting& s : sightings) {
        place.n_supports += supports(s, point);
        place.n_in_front += depth(s, point) > 0.0;
    }
    return place;
}

/// The place that most sightings support, among the meeting points of all and of each two. Of very many views the pairs
/// are thinned to a few thousand, evenly.
Place most_supported(const std::vector<Sighting>& sightings) {
    Place best;
    best.point = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    const auto try_point = [&](const std::optional<Vec3>& point) {
        if (!point) return;
        const Place place = weigh(*point, sightings);
        if (place.is_better_than(best)) best = place;
    };
    try_point(meeting_point(sightings));
    const std::size_t step = 1 + sightings.size() / 64;
    for (std::size_t i = 0; i < sightings.size(); i += step) {
        for (std::size_t j = i + 1; j < sightings.size() && best.n_supports < sightings.size(); j += step) {
            try_point(meeting_point(std::vector<Sighting>{sightings[i], sightings[j]}));
        }
    }
    return best;
}

std::string text_of(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

constexpr const char* convention = "x ~ K (R X + t) from world to camera, z forward";

}  // namespace

void check_object_position(std::span<const View* const> views, const std::string& cameras_file, Faults& faults) {
    std::vector<Sighting> sightings;
    for (const View* view : views) sightings.push_back(sight(*view));
    const Place object = most_supported(sightings);
    const std::string n_views = std::to_string(views.size());
    if (2 * object.n_supports <= sightings.size()) {
        faults.add(cameras_file, "only " + std::to_string(object.n_supports) + " of " + n_views +
                                     " views agree on where the object is; expected " + convention);
        return;
    }
    if (object.n_supports == sightings.size() && object.n_in_front == 0) {
        faults.add(cameras_file,
                   "the object is behind all " + n_views + " cameras; expected positive depth, " + convention);
        return;
    }
    for (const Sighting& s : sightings) {
        const double z = depth(s, object.point);
        if (!(z > 0.0))
            faults.add(s.view->name, "the object is behind the camera, at depth " + text_of(z) +
                                         "; expected positive depth, " + convention);
        else if (!supports(s, object.point))
            faults.add(s.view->name, "its mask shows the object where the other views say it is not; expected " +
                                         std::string(convention) + ", and the mask of this photograph");
    }
}

}  // namespace anyrate
