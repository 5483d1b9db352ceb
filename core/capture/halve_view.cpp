#include "core/capture/halve_view.h"

#include <cassert>

namespace anyrate {
namespace {

template <class Pixel, class Reduce>
Image<Pixel> halved(const Image<Pixel>& image, const Reduce& of_four) {
    Image<Pixel> half(image.width / 2, image.height / 2);
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
            half(x, y) = of_four(image(2 * x, 2 * y), image(2 * x + 1, 2 * y), image(2 * x, 2 * y + 1),
                                 image(2 * x + 1, 2 * y + 1));
    return half;
}

Rgb8 mean(const Rgb8& a, const Rgb8& b, const Rgb8& c, const Rgb8& d) {
    const auto rounded = [](int sum) { return static_cast<std::uint8_t>((sum + 2) / 4); };
    return {rounded(a.r + b.r + c.r + d.r), rounded(a.g + b.g + c.g + d.g), rounded(a.b + b.b + c.b + d.b)};
}

std::uint8_t is_mostly_object(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
    return (a != 0) + (b != 0) + (c != 0) + (d != 0) >= 2 ? 255 : 0;
}

}  // namespace

void halve(View& view) {
    assert(view.image.width >= 2 && view.image.height >= 2);
    view.image = halved(view.image, mean);
    view.mask = halved(view.mask, is_mostly_object);
    // The centre of the pixel (x, y) stands at (2 x + 1/2, 2 y + 1/2) of the larger image.
    Mat3 half_from_full;
    half_from_full << 0.5, 0, -0.25, 0, 0.5, -0.25, 0, 0, 1;
    view.camera.K = half_from_full * view.camera.K;
    view.camera.width = view.image.width;
    view.camera.height = view.image.height;
}

}  // namespace anyrate
