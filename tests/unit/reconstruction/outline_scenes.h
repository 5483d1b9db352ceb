#pragma once
// Captures of bodies whose outline is known exactly: a pixel belongs to the mask if the ray through its centre meets
// the body. No images: the first step of the method looks at masks only.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/capture/capture.h"

namespace anyrate {

/// Whether the ray from a point in a unit direction meets the body.
using RayTest = std::function<bool(const Vec3& from, const Vec3& direction)>;

inline RayTest ball(double radius, const Vec3& centre = Vec3::Zero()) {
    return [=](const Vec3& from, const Vec3& direction) {
        return (centre - from).cross(direction).squaredNorm() <= radius * radius;
    };
}

/// All points nearer than `radius` to the segment from `a` to `b`.
inline RayTest rod(const Vec3& a, const Vec3& b, double radius) {
    return [=](const Vec3& from, const Vec3& direction) {
        const Vec3 along = b - a, to_a = a - from;
        // The point a + s along nearest to the line: both perpendicular to the direction.
        const Vec3 along_across = along - along.dot(direction) * direction;
        const Vec3 to_a_across = to_a - to_a.dot(direction) * direction;
        const double s = std::clamp(-to_a_across.dot(along_across) / along_across.squaredNorm(), 0.0, 1.0);
        return (to_a_across + s * along_across).squaredNorm() <= radius * radius;
    };
}

inline View outline_view(const Camera& camera, const RayTest& meets) {
    View view;
    view.name = "outline";
    view.camera = camera;
    view.image = ColourImage(camera.width, camera.height);
    view.mask = MaskImage(camera.width, camera.height);
    const Mat3 world_from_pixel = camera.R.transpose() * camera.K.inverse();
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            view.mask(x, y) = meets(camera.centre(), (world_from_pixel * Vec3(x, y, 1)).normalized()) ? 255 : 0;
    return view;
}

/// The camera that sees the world's image under X -> scale X + offset as `camera` sees the world.
inline Camera moved(Camera camera, double scale, const Vec3& offset) {
    camera.t = scale * camera.t - camera.R * offset;
    return camera;
}

/// Volume inside a surface by the divergence theorem: a third of the flux of the position.
template <class Points>
double enclosed_volume(const Points& points) {
    double volume = 0.0;
    for (const auto& point : points)
        volume += point.area * point.normal.dot(point.position - points.front().position) / 3.0;
    return volume;
}

}  // namespace anyrate
