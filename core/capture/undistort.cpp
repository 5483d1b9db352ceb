#include "core/capture/undistort.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace anyrate {

Vec2 Distortion::distort(const Vec2& point) const {
    const double x = point.x(), y = point.y(), r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

namespace {

/// Square of the radius up to which the radial part grows, looked for up to `largest_r2`.
double turning_r2(const Distortion& lens, double largest_r2) {
    constexpr int n_steps = 4096;  // a step is far below a pixel
    for (int i = 1; i <= n_steps; ++i) {
        const double r2 = largest_r2 * i / n_steps;
        const double slope = 1.0 + r2 * (3.0 * lens.k1 + r2 * (5.0 * lens.k2 + r2 * 7.0 * lens.k3));
        if (slope <= 0.0) return largest_r2 * (i - 1) / n_steps;
    }
    return std::numeric_limits<double>::infinity();
}

/// Square of the largest radius of the image's corners, in the plane at depth 1.
double corner_r2(const Camera& camera, const Mat3& K_inverse) {
    double r2 = 0.0;
    for (const double x : {-0.5, camera.width - 0.5})
        for (const double y : {-0.5, camera.height - 0.5})
            r2 = std::max(r2, (K_inverse * Vec3(x, y, 1.0)).head<2>().squaredNorm());
    return r2;
}

/// The four pixels around a position, clamped to the image, and their bilinear weights.
struct Footprint {
    std::array<std::size_t, 4> pixel;
    std::array<double, 4> weight;
};

Footprint footprint(const Vec2& at, int width, int height) {
    const double left = std::floor(at.x()), top = std::floor(at.y()), fx = at.x() - left, fy = at.y() - top;
    const auto column = [&](double x) { return static_cast<std::size_t>(std::clamp(x, 0.0, width - 1.0)); };
    const auto row = [&](double y) {
        return static_cast<std::size_t>(std::clamp(y, 0.0, height - 1.0)) * static_cast<std::size_t>(width);
    };
    return {{row(top) + column(left), row(top) + column(left + 1), row(top + 1) + column(left),
             row(top + 1) + column(left + 1)},
            {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

Rgb8 blend(const ColourImage& image, const Footprint& around) {
    double r = 0.5, g = 0.5, b = 0.5;  // rounds
    for (std::size_t i = 0; i < 4; ++i) {
        const Rgb8 colour = image.pixels[around.pixel[i]];
        r += around.weight[i] * colour.r;
        g += around.weight[i] * colour.g;
        b += around.weight[i] * colour.b;
    }
    return {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
}

double coverage(const MaskImage& mask, const Footprint& around) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        if (mask.pixels[around.pixel[i]] != 0) sum += around.weight[i];
    return sum;
}

}  // namespace

void undistort(View& view, const Distortion& lens) {
    const int width = view.image.width, height = view.image.height;
    const Mat3 K_inverse = view.camera.K.inverse();
    const double r2_limit = turning_r2(lens, corner_r2(view.camera, K_inverse));
    ColourImage image(width, height);
    MaskImage mask(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Vec2 ideal = (K_inverse * Vec3(x, y, 1.0)).head<2>();
            const Vec2 seen = (view.camera.K * lens.distort(ideal).homogeneous()).head<2>();
            // Also false for what is not a number.
            const bool is_shown = ideal.squaredNorm() <= r2_limit && seen.x() >= -0.5 && seen.x() <= width - 0.5 &&
                                  seen.y() >= -0.5 && seen.y() <= height - 0.5;
            if (!is_shown) continue;
            const Footprint around = footprint(seen, width, height);
            image(x, y) = blend(view.image, around);
            mask(x, y) = coverage(view.mask, around) >= 0.5 ? 255 : 0;
        }
    }
    view.image = std::move(image);
    view.mask = std::move(mask);
}

}  // namespace anyrate
