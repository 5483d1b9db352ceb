#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/reconstruction/float4.h"

namespace anyrate {

/// A colour with its derivatives by the pixel position, from a bilinear patch: red, green, blue, 0..255, and a spare
/// lane that is the same wherever it is sampled.
struct ColourPatch {
    Float4 c, dx, dy;
};

/// Two neighbouring RGBA pixels as floats. GCC takes shuffles for what they are, 13 instructions less a pixel than for
/// four conversions; by way of an integer, since bytes copied into a wider vector are stored and loaded again, which
/// stalls for longer than all the rest takes.
inline void load_pixels(const std::uint8_t* rgba, Float4& left, Float4& right) {
    using Byte16 = std::uint8_t __attribute__((vector_size(16)));
    using Short8 = std::uint16_t __attribute__((vector_size(16)));
    using Long2 = std::uint64_t __attribute__((vector_size(16)));
    using Int4 = std::int32_t __attribute__((vector_size(16)));
    static_assert(std::endian::native == std::endian::little, "a zero byte behind each makes it wider");
    std::uint64_t both;
    std::memcpy(&both, rgba, 8);
    const auto bytes = reinterpret_cast<Byte16>(Long2{both, 0});
    const auto words = reinterpret_cast<Short8>(
        __builtin_shufflevector(bytes, Byte16{}, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23));
    left = __builtin_convertvector(
        reinterpret_cast<Int4>(__builtin_shufflevector(words, Short8{}, 0, 8, 1, 9, 2, 10, 3, 11)), Float4);
    right = __builtin_convertvector(
        reinterpret_cast<Int4>(__builtin_shufflevector(words, Short8{}, 4, 12, 5, 13, 6, 14, 7, 15)), Float4);
}

/// Samples RGBA pixels (photo_images.h) at (x, y) >= 0 pixels from `origin`, rows `row` bytes apart.
/// @return false where any of the four pixels is not the object's alone
inline bool sample_patch(const std::uint8_t* origin, std::ptrdiff_t row, float x, float y, ColourPatch& out) {
    const auto x0 = static_cast<std::int32_t>(x), y0 = static_cast<std::int32_t>(y);
    const std::uint8_t* top = origin + y0 * row + 4 * static_cast<std::ptrdiff_t>(x0);
    const std::uint8_t* bottom = top + row;
    if ((top[3] & top[7] & bottom[3] & bottom[7]) == 0) return false;
    const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
    Float4 a, b, c, d;
    load_pixels(top, a, b);
    load_pixels(bottom, c, d);
    const Float4 left = c - a, right = d - b;
    out.dy = left + u * (right - left);
    out.dx = (b - a) + v * (right - left);
    const Float4 on_left = a + v * left;
    out.c = on_left + u * ((b + v * right) - on_left);
    return true;
}

}  // namespace anyrate
