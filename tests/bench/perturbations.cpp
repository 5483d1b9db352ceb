#include "tests/bench/perturbations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/mesh/normals.h"
#include "core/parallel.h"
#include "core/simulation/render.h"
#include "tests/bench/image_window.h"

namespace anyrate::bench {
namespace {

/// In [0, 1), the same on every platform (the standard distributions are not).
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

std::uint8_t multiply(std::uint8_t level, double gain) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(gain * level), 0L, 255L));
}

/// The pixels of a window themselves: nothing is averaged, so the noise and the sharpness stay what they are.
template <typename Image>
Image cut_out(const Image& image, int left, int top, int width, int height) {
    Image part(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) part(x, y) = image(left + x, top + y);
    return part;
}

/// Whether a pixel of the value `wanted` lies within the radius.
bool is_near(const MaskImage& mask, int x, int y, int radius, bool wanted) {
    for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i)
            if (i * i + j * j <= radius * radius && mask.contains(x + i, y + j) && (mask(x + i, y + j) != 0) == wanted)
                return true;
    return false;
}

}  // namespace

void move_world(Capture& capture, double scale, const Vec3& origin) {
    // R p + t = R (p' - origin) / scale + t; a camera is the same up to a factor of its depths.
    for (View& view : capture.views) view.camera.t = scale * view.camera.t - view.camera.R * origin;
}

void move_world(Mesh& mesh, double scale, const Vec3& origin) {
    for (Vec3& vertex : mesh.vertices) vertex = scale * vertex + origin;
}

void resample(Capture& capture, double factor, std::size_t step) {
    parallel_for(
        (capture.views.size() + step - 1) / step,
        [&](std::size_t i) {
            View& view = capture.views[step * i];
            const int width = static_cast<int>(std::lround(factor * view.image.width));
            const int height = static_cast<int>(std::lround(factor * view.image.height));
            view = look_through(view, {-0.5, -0.5, double(view.image.width), double(view.image.height)}, width, height);
        },
        1);
}

void change_gain(Capture& capture, double range, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (View& view : capture.views) {
        const double gain = 1 + range * (2 * uniform(random) - 1);
        for (Rgb8& c : view.image.pixels) c = {multiply(c.r, gain), multiply(c.g, gain), multiply(c.b, gain)};
    }
}

void grow_masks(Capture& capture, int radius_px) {
    const int radius = std::abs(radius_px);
    parallel_for(
        capture.views.size(),
        [&](std::size_t i) {
            const MaskImage before = capture.views[i].mask;
            MaskImage& mask = capture.views[i].mask;
            for (int y = 0; y < mask.height; ++y)
                for (int x = 0; x < mask.width; ++x)
                    if (is_near(before, x, y, radius, radius_px > 0)) mask(x, y) = radius_px > 0 ? 255 : 0;
        },
        1);
}

void disturb_poses(Capture& capture, double distance_px, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (View& view : capture.views) {
        const double direction = 2 * std::numbers::pi * uniform(random);
        const Vec3 shift_px(distance_px * std::cos(direction), distance_px * std::sin(direction), 0);
        // The middle of the image is seen along K^-1 x; turn the camera so that it is seen at x + shift.
        const Mat3 K_inverse = view.camera.K.inverse();
        const Vec3 middle(0.5 * (view.image.width - 1), 0.5 * (view.image.height - 1), 1);
        const Mat3 turn =
            Eigen::Quaterniond::FromTwoVectors(K_inverse * middle, K_inverse * (middle + shift_px)).toRotationMatrix();
        view.camera.R = turn * view.camera.R;
        view.camera.t = turn * view.camera.t;
    }
}

void keep_every(Capture& capture, int n) {
    std::vector<View> kept;
    for (std::size_t i = 0; i < capture.views.size(); i += static_cast<std::size_t>(n))
        kept.push_back(std::move(capture.views[i]));
    capture.views = std::move(kept);
}

void crop(Capture& capture, double part, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (View& view : capture.views) {
        const int width = static_cast<int>(std::lround(part * view.image.width));
        const int height = static_cast<int>(std::lround(part * view.image.height));
        const int left = static_cast<int>(uniform(random) * (view.image.width - width + 1));
        const int top = static_cast<int>(uniform(random) * (view.image.height - height + 1));
        view.camera = look_through(view.camera, {left - 0.5, top - 0.5, double(width), double(height)}, width, height);
        view.image = cut_out(view.image, left, top, width, height);
        view.mask = cut_out(view.mask, left, top, width, height);
    }
}

void fade_texture(Capture& capture, const Mesh& surface, double kept, std::uint64_t seed) {
    if (kept >= 1) return;
    const Model clay{
        .surface = surface, .normals = vertex_normals(surface), .appearance = [](const Vec3&, const Vec3& normal) {
            return Vec3(Vec3(0.55, 0.48, 0.42) * studio_light(normal));
        }};
    // The photograph's own noise, one level, fades with it; with the clay's the sum has one level again.
    const double noise = std::sqrt(1 - kept * kept) / (1 - kept);
    const auto blend = [&](std::uint8_t photo, std::uint8_t plain) {
        return static_cast<std::uint8_t>(std::lround(kept * photo + (1 - kept) * plain));
    };
    for (std::size_t i = 0; i < capture.views.size(); ++i) {
        View& view = capture.views[i];
        const ColourImage plain = render_view(clay, view.camera, view.name, {.noise = noise, .seed = seed + i}).image;
        for (std::size_t k = 0; k < plain.pixels.size(); ++k) {
            Rgb8& pixel = view.image.pixels[k];
            const Rgb8& p = plain.pixels[k];
            pixel = {blend(pixel.r, p.r), blend(pixel.g, p.g), blend(pixel.b, p.b)};
        }
    }
}

}  // namespace anyrate::bench
