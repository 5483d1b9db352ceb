#include "core/reconstruction/silhouette_cone.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

namespace anyrate {
namespace {

// ---- masks of 0 and 1

// Every pixel becomes the best over the square of pixels from (first, first) to (last, last) around it; what lies
// outside the image has no say.
template <class Best>
MaskImage over_square(const MaskImage& mask, int first, int last, const Best& best) {
    const auto combine = [&best](const std::uint8_t* from, std::uint8_t* to, int n) {
        for (int i = 0; i < n; ++i) to[i] = best(to[i], from[i]);
    };
    const int width = mask.width;
    MaskImage rows = mask;
    for (int y = 0; y < mask.height; ++y)
        for (int offset = first; offset <= last; ++offset)
            if (const int n = width - std::abs(offset); n > 0)
                combine(&mask(std::max(0, offset), y), &rows(std::max(0, -offset), y), n);
    MaskImage result = rows;
    for (int y = 0; y < mask.height; ++y)
        for (int from = std::max(0, y + first); from <= std::min(mask.height - 1, y + last); ++from)
            combine(&rows(0, from), &result(0, y), width);
    return result;
}

MaskImage dilate(const MaskImage& mask, int first, int last) {
    return over_square(mask, first, last, [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
}
MaskImage erode(const MaskImage& mask, int first, int last) {
    return over_square(mask, first, last, [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); });
}

// Parts narrower than `width` grow by a pixel on either side. They are what an opening by a square of that width loses,
// less the tips of corners, which touch what it keeps.
MaskImage with_grown_thin_parts(MaskImage object, int width) {
    const MaskImage kept = dilate(erode(object, 0, width - 1), 1 - width, 0);
    const MaskImage kept_and_around = dilate(kept, -1, 1);
    MaskImage thin = object;
    for (std::size_t i = 0; i < thin.pixels.size(); ++i) thin.pixels[i] &= !kept_and_around.pixels[i];
    const MaskImage grown = dilate(thin, -1, 1);
    for (std::size_t i = 0; i < object.pixels.size(); ++i) object.pixels[i] |= grown.pixels[i];
    return object;
}

// The two repairs of the class's comment; the result is 0 or 1. Measured on 40 rods in random directions: 3.2 pixels
// wide, 9 fell apart on the grid of two-pixel cells without the growth by 5, none with it.
MaskImage repaired(const MaskImage& mask) {
    MaskImage object = mask;
    for (std::uint8_t& pixel : object.pixels) pixel = pixel != 0;
    object = erode(dilate(object, -1, 1), -1, 1);
    return with_grown_thin_parts(with_grown_thin_parts(std::move(object), 2), 5);
}

bool touches_frame(const MaskImage& mask) {
    const auto is_object = [](std::uint8_t pixel) { return pixel != 0; };
    if (std::any_of(mask.pixels.begin(), mask.pixels.begin() + mask.width, is_object)) return true;
    if (std::any_of(mask.pixels.end() - mask.width, mask.pixels.end(), is_object)) return true;
    for (int y = 0; y < mask.height; ++y)
        if (is_object(mask(0, y)) || is_object(mask(mask.width - 1, y))) return true;
    return false;
}

// ---- signed distance

constexpr int reach_px = 8;    // cut off there
constexpr int n_passes = 4;    // of the blur, a pixel each
constexpr int margin_px = 16;  // around the object: repairs, reach and blur end before its border

// The part of the image that the cone is made of: the object and a margin, as far as the image goes.
PixelBox box_around(const MaskImage& mask) {
    PixelBox box;
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (mask(x, y) != 0) box.extend(x, y);
    if (box.is_empty()) return {0, 0, std::min(1, mask.width), std::min(1, mask.height)};
    return {std::max(0, box.x0 - margin_px), std::max(0, box.y0 - margin_px), std::min(mask.width, box.x1 + margin_px),
            std::min(mask.height, box.y1 + margin_px)};
}

MaskImage cut_out(const MaskImage& mask, const PixelBox& box) {
    MaskImage part(box.width(), box.height());
    for (int y = 0; y < part.height; ++y) std::copy_n(&mask(box.x0, box.y0 + y), part.width, &part(0, y));
    return part;
}

// Distance of every pixel centre to the nearest one with mask == target, exact up to reach_px, cut off there.
// Separable: first within columns, then the nearest over the row's columns (Saito and Toriwaki 1994, with a bounded
// reach).
Image<float> distance_to(const MaskImage& mask, std::uint8_t target) {
    constexpr float far = reach_px * reach_px;
    Image<float> in_column(mask.width, mask.height, reach_px);
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
            if (mask(x, y) == target)
                in_column(x, y) = 0.0f;
            else if (y > 0)
                in_column(x, y) = std::min<float>(reach_px, in_column(x, y - 1) + 1.0f);
        }
    for (int y = mask.height - 2; y >= 0; --y)
        for (int x = 0; x < mask.width; ++x) in_column(x, y) = std::min(in_column(x, y), in_column(x, y + 1) + 1.0f);

    Image<float> result(mask.width, mask.height, far);
    for (int y = 0; y < mask.height; ++y)
        for (int offset = -reach_px; offset <= reach_px; ++offset) {
            const int n = mask.width - std::abs(offset);
            if (n <= 0) continue;
            const float* from = &in_column(std::max(0, offset), y);
            float* to = &result(std::max(0, -offset), y);
            const auto across = static_cast<float>(offset * offset);
            for (int i = 0; i < n; ++i) to[i] = std::min(to[i], from[i] * from[i] + across);
        }
    for (float& squared : result.pixels) squared = std::sqrt(squared);
    return result;
}

// One pass of the kernel (1 2 1) / 4 along both axes; the border repeats itself.
Image<float> blurred(const Image<float>& image) {
    Image<float> rows = image;
    for (int y = 0; y < image.height; ++y)
        for (int x = 1; x + 1 < image.width; ++x)
            rows(x, y) = 0.25f * (image(x - 1, y) + image(x + 1, y)) + 0.5f * image(x, y);
    Image<float> result = rows;
    for (int y = 1; y + 1 < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            result(x, y) = 0.25f * (rows(x, y - 1) + rows(x, y + 1)) + 0.5f * rows(x, y);
    return result;
}

// A pixel of an exact mask tells on which side of the outline its centre lies, and no more. So the distance to the
// mask's staircase is smoothed (standard deviation 1.4 pixels in all) under that constraint: a straight edge becomes
// straight, and a tip or a thin part keeps its pixels.
Image<float> smooth_signed_distance(const MaskImage& mask) {
    constexpr float least_px = 0.05f;
    const Image<float> to_background = distance_to(mask, 0);
    Image<float> distance = distance_to(mask, 1);
    for (std::size_t i = 0; i < distance.pixels.size(); ++i)
        distance.pixels[i] = mask.pixels[i] ? 0.5f - to_background.pixels[i] : distance.pixels[i] - 0.5f;
    for (int pass = 0; pass < n_passes; ++pass) {
        distance = blurred(distance);
        for (std::size_t i = 0; i < distance.pixels.size(); ++i)
            distance.pixels[i] =
                mask.pixels[i] ? std::min(distance.pixels[i], -least_px) : std::max(distance.pixels[i], least_px);
    }
    return distance;
}

}  // namespace

SilhouetteCone::SilhouetteCone(const View& view)
    : centre_(view.camera.centre()), pixels_per_radian_(std::sqrt(view.camera.K(0, 0) * view.camera.K(1, 1))) {
    const PixelBox box = box_around(view.mask);
    Mat3 K = view.camera.K;
    K.row(0) -= box.x0 * K.row(2);
    K.row(1) -= box.y0 * K.row(2);
    P_ << K * view.camera.R, K * view.camera.t;
    frame_ = {-box.x0, -box.y0, view.mask.width - box.x0, view.mask.height - box.y0};
    const MaskImage mask = repaired(cut_out(view.mask, box));
    complete_ = !touches_frame(mask);
    distance_px_ = smooth_signed_distance(mask);
    count_pixels(mask, view.camera.R.transpose() * K.inverse());
}

void SilhouetteCone::count_pixels(const MaskImage& mask, const Mat3& world_from_pixel) {
    sum_ = Image<std::uint32_t>(mask.width + 1, mask.height + 1);
    Vec2 moment = Vec2::Zero();
    for (int y = 0; y < mask.height; ++y) {
        std::uint32_t in_row = 0;
        for (int x = 0; x < mask.width; ++x) {
            in_row += mask(x, y);
            sum_(x + 1, y + 1) = sum_(x + 1, y) + in_row;
            if (mask(x, y)) moment += Vec2(x, y);
        }
    }
    const std::uint32_t n_pixels = sum_(mask.width, mask.height);
    if (n_pixels > 0) axis_ = (world_from_pixel * Vec2(moment / n_pixels).homogeneous()).normalized();
}

std::int64_t SilhouetteCone::object_pixels(int x0, int y0, int x1, int y1) const {
    const auto sum = [this](int x, int y) {
        return static_cast<std::int64_t>(sum_(std::clamp(x, 0, sum_.width - 1), std::clamp(y, 0, sum_.height - 1)));
    };
    return sum(x1 + 1, y1 + 1) - sum(x0, y1 + 1) - sum(x1 + 1, y0) + sum(x0, y0);
}

Cover SilhouetteCone::cover(const Vec3& centre, double half_edge) const {
    const Vec3 projected = P_ * centre.homogeneous();
    const double depth_reach = half_edge * P_.block<1, 3>(2, 0).lpNorm<1>();
    const Cover not_in_image = complete_ ? Cover::background : Cover::unseen;
    if (projected.z() + depth_reach <= 0.0) return not_in_image;
    const double least_depth = projected.z() - depth_reach;
    if (least_depth <= 0.0) return Cover::mixed;

    // With numerator N and depth D, u - u0 = ((N - u0 D) - 0) / D, whose numerator is linear and zero at the centre.
    const double u0 = projected.x() / projected.z();
    const double v0 = projected.y() / projected.z();
    const double du = half_edge * (P_.block<1, 3>(0, 0) - u0 * P_.block<1, 3>(2, 0)).lpNorm<1>() / least_depth;
    const double dv = half_edge * (P_.block<1, 3>(1, 0) - v0 * P_.block<1, 3>(2, 0)).lpNorm<1>() / least_depth;
    const Frame frame = frame_in_pixels();
    if (u0 + du < frame.left || v0 + dv < frame.top || u0 - du > frame.right || v0 - dv > frame.bottom)
        return not_in_image;
    const bool contained =
        u0 - du >= frame.left && v0 - dv >= frame.top && u0 + du <= frame.right && v0 + dv <= frame.bottom;
    if (!contained && !complete_) return Cover::mixed;

    // All pixels that the interpolation of a point of the footprint may read.
    const auto first = [](double low, int least) { return std::max(least, static_cast<int>(std::floor(low))); };
    const auto last = [](double high, int size) { return std::min(size - 1, static_cast<int>(std::ceil(high))); };
    const int x0 = first(u0 - du, frame_.x0), x1 = last(u0 + du, frame_.x1);
    const int y0 = first(v0 - dv, frame_.y0), y1 = last(v0 + dv, frame_.y1);
    const std::int64_t n_object = object_pixels(x0, y0, x1, y1);
    if (n_object == 0) return Cover::background;
    return n_object == static_cast<std::int64_t>(x1 - x0 + 1) * (y1 - y0 + 1) ? Cover::object : Cover::mixed;
}

std::optional<double> SilhouetteCone::distance(const Vec3& point) const {
    const Vec3 projected = P_ * point.homogeneous();
    if (projected.z() <= 0.0) return complete_ ? std::optional(std::numeric_limits<double>::infinity()) : std::nullopt;
    const double u = projected.x() / projected.z();
    const double v = projected.y() / projected.z();
    if (!complete_) {
        const Frame frame = frame_in_pixels();
        if (!(u >= frame.left && v >= frame.top && u <= frame.right && v <= frame.bottom)) return std::nullopt;
    }

    // Beyond what is kept, and beyond the image of a complete view, the background of the border goes on.
    const int width = distance_px_.width, height = distance_px_.height;
    const double x = std::clamp(u, 0.0, width - 1.0);
    const double y = std::clamp(v, 0.0, height - 1.0);
    const int x0 = static_cast<int>(x), x1 = std::min(x0 + 1, width - 1);
    const int y0 = static_cast<int>(y), y1 = std::min(y0 + 1, height - 1);
    const double a = x - x0, b = y - y0;
    const auto in_row = [&](int row) { return (1 - a) * distance_px_(x0, row) + a * distance_px_(x1, row); };
    const double distance_px = (1 - b) * in_row(y0) + b * in_row(y1);
    return distance_px * projected.z() / pixels_per_radian_;
}

double SilhouetteCone::pixel_size(const Vec3& point) const {
    return P_.row(2).dot(point.homogeneous()) / pixels_per_radian_;
}

}  // namespace anyrate
