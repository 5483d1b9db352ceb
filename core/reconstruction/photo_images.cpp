#include "core/reconstruction/photo_images.h"

#include <algorithm>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A pixel counts as the object's alone if its four neighbours are the object's too: the silhouette's own pixels are a
/// mixture with the background.
bool is_pure(const MaskImage& mask, int x, int y) {
    const auto inside = [&](int i, int j) { return mask.contains(i, j) && mask(i, j) != 0; };
    return inside(x, y) && inside(x - 1, y) && inside(x + 1, y) && inside(x, y - 1) && inside(x, y + 1);
}

PhotoLevel finest_level(const View& view) {
    PhotoLevel level;
    level.width = view.image.width;
    level.height = view.image.height;
    level.P = view.camera.P();
    level.rgba.resize(4 * at(level.width) * at(level.height));
    std::uint8_t* out = level.rgba.data();
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x, out += 4) {
            const Rgb8 c = view.image(x, y);
            out[0] = c.r;
            out[1] = c.g;
            out[2] = c.b;
            out[3] = is_pure(view.mask, x, y) ? 255 : 0;
        }
    return level;
}

/// Mean of the children that are the object's; the pixel is the object's if at least three of four are.
void reduce_pixel(const PhotoLevel& fine, int x, int y, std::uint8_t* out) {
    int sum[3] = {0, 0, 0}, n = 0;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const std::uint8_t* p =
                fine.pixel(std::min(2 * x + dx, fine.width - 1), std::min(2 * y + dy, fine.height - 1));
            if (p[3] == 0) continue;
            for (int k = 0; k < 3; ++k) sum[k] += p[k];
            ++n;
        }
    for (int k = 0; k < 3; ++k) out[k] = n > 0 ? static_cast<std::uint8_t>((sum[k] + n / 2) / n) : std::uint8_t{0};
    out[3] = n >= 3 ? 255 : 0;
}

PhotoLevel half_level(const PhotoLevel& fine) {
    PhotoLevel level = without_colours(fine);
    level.rgba.resize(4 * at(level.width) * at(level.height));
    std::uint8_t* out = level.rgba.data();
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x, out += 4) reduce_pixel(fine, x, y, out);
    return level;
}

}  // namespace

PhotoLevel without_colours(const PhotoLevel& fine) {
    PhotoLevel level;
    level.width = (fine.width + 1) / 2;
    level.height = (fine.height + 1) / 2;
    // Pixel (x, y) of the fine level stands at ((x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5) of the coarse one.
    Mat3 coarse_from_fine;
    coarse_from_fine << 0.5, 0, -0.25, 0, 0.5, -0.25, 0, 0, 1;
    level.P = coarse_from_fine * fine.P;
    return level;
}

PhotoImages make_photo_images(const Capture& capture, int n_levels) {
    int smallest_side = 1 << 30;
    for (const View& view : capture.views)
        smallest_side = std::min({smallest_side, view.image.width, view.image.height});
    while (n_levels > 1 && (smallest_side >> (n_levels - 1)) < 16) --n_levels;

    PhotoImages images;
    images.views.resize(capture.views.size());
    parallel_for(
        capture.views.size(),
        [&](std::size_t i) {
            const View& view = capture.views[i];
            PhotoView& out = images.views[i];
            out.centre = view.camera.centre();
            out.focal_px = 0.5 * (view.camera.K(0, 0) + view.camera.K(1, 1));
            out.levels.push_back(finest_level(view));
            for (int l = 1; l < n_levels; ++l) out.levels.push_back(half_level(out.levels.back()));
        },
        1);
    return images;
}

}  // namespace anyrate
