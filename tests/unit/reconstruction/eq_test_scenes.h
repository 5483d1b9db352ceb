#pragma once
// Captures with a known answer: cameras on a circle that look at the origin, images that are a function of the pixel.
#include <cmath>
#include <functional>

#include "core/capture/capture.h"

namespace anyrate {

/// A camera at `centre` looking at the origin, z up; `focal` in pixels.
inline Camera look_at_origin(const Vec3& centre, int width, int height, double focal) {
    Camera camera;
    const Vec3 forward = -centre.normalized();
    const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
    camera.R.row(0) = right.transpose();
    camera.R.row(1) = forward.cross(right).transpose();
    camera.R.row(2) = forward.transpose();
    camera.t = -camera.R * centre;
    camera.K << focal, 0, (width - 1) / 2.0, 0, focal, (height - 1) / 2.0, 0, 0, 1;
    camera.width = width;
    camera.height = height;
    return camera;
}

/// What stands at a ray's first hit with the unit sphere around the origin: linear in the point, so that neither the
/// sampling nor its derivative has a kink. Outside the sphere's outline the mask is 0.
inline Capture painted_sphere(int n_views, int size, const std::function<Vec3(const Vec3&)>& paint) {
    Capture capture;
    for (int i = 0; i < n_views; ++i) {
        const double angle = 2 * M_PI * i / n_views;
        View view;
        view.name = std::to_string(i);
        view.camera = look_at_origin(Vec3(5 * std::cos(angle), 5 * std::sin(angle), 1), size, size, 2.0 * size);
        view.image = ColourImage(size, size);
        view.mask = MaskImage(size, size);
        const Vec3 centre = view.camera.centre();
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Vec3 ray = (view.camera.R.transpose() * view.camera.K.inverse() * Vec3(x, y, 1)).normalized();
                const double b = centre.dot(ray), discriminant = b * b - centre.squaredNorm() + 1;
                if (discriminant < 0) continue;
                const Vec3 c = paint(centre + (-b - std::sqrt(discriminant)) * ray);
                view.mask(x, y) = 255;
                view.image(x, y) = {static_cast<std::uint8_t>(c.x()), static_cast<std::uint8_t>(c.y()),
                                    static_cast<std::uint8_t>(c.z())};
            }
        capture.views.push_back(std::move(view));
    }
    return capture;
}

/// A paint that varies over about a fifth of the radius, different in every channel.
inline Vec3 wavy_paint(const Vec3& p) {
    return Vec3(128 + 90 * std::sin(9 * p.x() + 2 * p.z()), 128 + 90 * std::sin(8 * p.y() - 3 * p.x()),
                128 + 90 * std::sin(10 * p.z() + 4 * p.y()));
}

}  // namespace anyrate
