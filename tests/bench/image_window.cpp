#include "tests/bench/image_window.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace anyrate::bench {
namespace {

constexpr int samples_per_axis = 4;  // of an output pixel

/// Colour between the pixels, bilinear; beyond the border the border's.
Vec3 colour_at(const ColourImage& image, double x, double y) {
    x = std::clamp(x, 0.0, image.width - 1.0);
    y = std::clamp(y, 0.0, image.height - 1.0);
    const int x0 = std::min(static_cast<int>(x), std::max(image.width - 2, 0));
    const int y0 = std::min(static_cast<int>(y), std::max(image.height - 2, 0));
    const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
    const auto colour = [&](int i, int j) { return Vec3(image(i, j).r, image(i, j).g, image(i, j).b); };
    const double u = x - x0, v = y - y0;
    return (1 - v) * ((1 - u) * colour(x0, y0) + u * colour(x1, y0)) +
           v * ((1 - u) * colour(x0, y1) + u * colour(x1, y1));
}

bool is_object(const MaskImage& mask, double x, double y) {
    const int i = static_cast<int>(std::lround(x)), j = static_cast<int>(std::lround(y));
    return mask.contains(i, j) && mask(i, j) != 0;
}

std::uint8_t to_byte(double x) { return static_cast<std::uint8_t>(std::clamp(std::lround(x), 0L, 255L)); }

}  // namespace

Camera look_through(const Camera& camera, const Window& window, int width, int height) {
    const double scale_x = width / window.width, scale_y = height / window.height;
    // x' + 1/2 = scale (x - window.x), pixel centres being integers on both sides.
    Mat3 pixel_from_pixel = Mat3::Identity();
    pixel_from_pixel << scale_x, 0, -scale_x * window.x - 0.5,  //
        0, scale_y, -scale_y * window.y - 0.5,                  //
        0, 0, 1;
    Camera result = camera;
    result.K = pixel_from_pixel * camera.K;
    result.width = width;
    result.height = height;
    return result;
}

View look_through(const View& view, const Window& window, int width, int height) {
    View result{.name = view.name,
                .camera = look_through(view.camera, window, width, height),
                .image = ColourImage(width, height),
                .mask = MaskImage(width, height)};
    const double step_x = window.width / width / samples_per_axis, step_y = window.height / height / samples_per_axis;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            Vec3 colour = Vec3::Zero();
            int n_object = 0;
            for (int j = 0; j < samples_per_axis; ++j)
                for (int i = 0; i < samples_per_axis; ++i) {
                    const double px = window.x + (x * samples_per_axis + i + 0.5) * step_x;
                    const double py = window.y + (y * samples_per_axis + j + 0.5) * step_y;
                    colour += colour_at(view.image, px, py);
                    n_object += is_object(view.mask, px, py);
                }
            constexpr int n = samples_per_axis * samples_per_axis;
            colour /= n;
            result.image(x, y) = {to_byte(colour.x()), to_byte(colour.y()), to_byte(colour.z())};
            result.mask(x, y) = 2 * n_object >= n ? 255 : 0;
        }
    return result;
}

Window window_of_object(const MaskImage& mask, double margin) {
    int x_min = mask.width, x_max = -1, y_min = mask.height, y_max = -1;
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (mask(x, y) != 0) {
                x_min = std::min(x_min, x);
                x_max = std::max(x_max, x);
                y_min = std::min(y_min, y);
                y_max = std::max(y_max, y);
            }
    assert(x_max >= 0);
    const double width = x_max - x_min + 1, height = y_max - y_min + 1, border = margin * std::max(width, height);
    return {x_min - 0.5 - border, y_min - 0.5 - border, width + 2 * border, height + 2 * border};
}

}  // namespace anyrate::bench
