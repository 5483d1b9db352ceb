#pragma once
#include <cstddef>
#include <cstdint>

namespace anyrate {

/// Red, green, blue and a spare lane, as one register of any x86-64 or ARM: vector extension of GCC and Clang, whose
/// arithmetic is that of four floats.
using Float4 = float __attribute__((vector_size(16)));

inline float sum_of_lanes(const Float4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// A colour with its derivatives by the pixel position, from a bilinear patch; 0..255, the spare lane is 0.
struct ColourPatch {
    Float4 c, dx, dy;
};

/// Samples RGBA pixels (photo_images.h) at (x, y) >= 0 pixels from `origin`, rows `row` bytes apart.
/// @return false where any of the four pixels is not the object's alone
inline bool sample_patch(const std::uint8_t* origin, std::ptrdiff_t row, float x, float y, ColourPatch& out) {
    const auto x0 = static_cast<std::int32_t>(x), y0 = static_cast<std::int32_t>(y);
    const std::uint8_t* top = origin + y0 * row + 4 * static_cast<std::ptrdiff_t>(x0);
    const std::uint8_t* bottom = top + row;
    if ((top[3] & top[7] & bottom[3] & bottom[7]) == 0) return false;
    const auto pixel = [](const std::uint8_t* p) {
        return Float4{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0.0F};
    };
    const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
    const Float4 a = pixel(top), b = pixel(top + 4), c = pixel(bottom), d = pixel(bottom + 4);
    const Float4 left = c - a, right = d - b;
    out.dy = left + u * (right - left);
    out.dx = (b - a) + v * (right - left);
    const Float4 on_left = a + v * left;
    out.c = on_left + u * ((b + v * right) - on_left);
    return true;
}

}  // namespace anyrate
