#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/capture/capture.h"

namespace anyrate {

/// One level of one view's pyramid. Pixels are RGBA, 8 bits a channel; alpha is 255 where the colour is the object's
/// alone and 0 elsewhere (background, and the mixed pixels along the silhouette). Level l has half the pixels of
/// level l - 1 along each axis; P projects world points to this level's pixels (convention of camera.h).
struct PhotoLevel {
    int width = 0, height = 0;
    Mat34 P = Mat34::Zero();
    std::vector<std::uint8_t> rgba;

    const std::uint8_t* pixel(int x, int y) const {
        return rgba.data() +
               4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    }
};

/// A photograph prepared for sampling: its colour pyramid and the signed distance to its silhouette.
struct PhotoView {
    Vec3 centre = Vec3::Zero();      ///< of projection, world units
    double focal_px = 0;             ///< mean of the two focal lengths at level 0
    std::vector<PhotoLevel> levels;  ///< level 0 is the photograph
};

/// Colours and silhouettes of all views at all levels.
struct PhotoImages {
    std::vector<PhotoView> views;

    int n_views() const { return static_cast<int>(views.size()); }
    int n_levels() const { return views.empty() ? 0 : static_cast<int>(views.front().levels.size()); }
};

/// Size and camera of the next level, without its pixels.
PhotoLevel without_colours(const PhotoLevel& fine);

/// Builds the pyramids, `n_levels` of them or as many as leave the smaller side of the smallest image 16 pixels.
PhotoImages make_photo_images(const Capture& capture, int n_levels = 5);

/// Colour and its derivative by the pixel position, from the bilinear patch around (x, y).
struct ColourSample {
    float c[3];   ///< red, green, blue, 0..255
    float dx[3];  ///< per pixel
    float dy[3];
};

/// Samples level `image` at pixel (x, y). @return false where any of the four pixels is not the object's alone
inline bool sample_colour(const PhotoLevel& image, double x, double y, ColourSample& out) {
    if (!(x >= 0.0 && y >= 0.0 && x < image.width - 1 && y < image.height - 1)) return false;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const std::uint8_t* top = image.pixel(x0, y0);
    const std::uint8_t* bottom = top + 4 * static_cast<std::size_t>(image.width);
    if ((top[3] & top[7] & bottom[3] & bottom[7]) == 0) return false;
    const float u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
    for (int k = 0; k < 3; ++k) {
        const float a = top[k], b = top[4 + k], c = bottom[k], d = bottom[4 + k];
        const float dx_top = b - a, dx_bottom = d - c;
        out.dx[k] = dx_top + v * (dx_bottom - dx_top);
        const float left = a + v * (c - a), right = b + v * (d - b);
        out.dy[k] = (c - a) + u * ((d - b) - (c - a));
        out.c[k] = left + u * (right - left);
    }
    return true;
}

}  // namespace anyrate
