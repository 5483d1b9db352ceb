#include "core/reconstruction/window_correlation.h"

#include <algorithm>
#include <cstring>

#include "core/double4.h"
#include "core/reconstruction/float8.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::size_t in_whole_lanes(std::size_t n) { return (n + n_lanes - 1) / n_lanes * n_lanes; }

// What is summed over a window, a being the reference and b the other view: 1, a, a^2, b, b^2, a b.
enum Sum : std::size_t { count, a, aa, b, bb, ab, n_sums };

[[gnu::always_inline]] inline void load(const float* from, Float8& lanes) { std::memcpy(&lanes, from, sizeof lanes); }
[[gnu::always_inline]] inline void store(const Float8& lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); }

constexpr float per_brightness = 2.0f / white;

}  // namespace

PatchImage::PatchImage(const BrightnessImage& image) : width_(image.width), height_(image.height) {
    if (width_ < 2 || height_ < 2) return;
    patches_.reserve(at(width_ - 1) * at(height_ - 1));
    for (int y = 0; y + 1 < height_; ++y)
        for (int x = 0; x + 1 < width_; ++x) {
            std::uint64_t patch = 0;
            bool is_known = true;
            for (int i = 0; i < 4; ++i) {
                const std::uint16_t pixel = image(x + (i & 1), y + (i >> 1));
                is_known = is_known && pixel != unknown_brightness;
                patch |= std::uint64_t{pixel} << 16 * i;
            }
            patches_.push_back(is_known ? patch : ~std::uint64_t{0});
        }
}

WindowCorrelation::WindowCorrelation(const BrightnessImage& reference, int radius)
    : radius_(radius),
      reference_(reference.width + 2 * radius + static_cast<int>(n_lanes), reference.height + 2 * radius),
      known_(reference_) {
    for (int y = 0; y < reference.height; ++y)
        for (int x = 0; x < reference.width; ++x) {
            if (reference(x, y) == unknown_brightness) continue;
            reference_(x + radius, y + radius) = static_cast<float>(reference(x, y)) * per_brightness - 1.0f;
            known_(x + radius, y + radius) = 1.0f;
        }
}

int WindowCorrelation::pitch_of(const PixelBox& box) { return static_cast<int>(in_whole_lanes(at(box.width()))); }

void WindowCorrelation::correlate(const PatchImage& other, const Parallax& parallax, double inverse_depth,
                                  const PixelBox& box, std::vector<float>& correlations) {
    const int n_rows = 2 * radius_ + 1;
    pitch_ = in_whole_lanes(at(box.width() + 2 * radius_));
    rows_.resize(n_sums * pitch_ * at(n_rows) + n_lanes + at(2 * radius_));
    correlations.resize(at(pitch_of(box)) * at(box.height()));
    for (int y = box.y0 - radius_; y < box.y1 + radius_; ++y) {
        enter_row(other, parallax, inverse_depth, box, y);
        if (y >= box.y0 + radius_)
            correlate_row(box, y - radius_, correlations.data() + at(y - radius_ - box.y0) * at(pitch_of(box)));
    }
}

// Bilinear, along the row, in place of the oldest row.
ANYRATE_VECTOR_CLONES
void WindowCorrelation::enter_row(const PatchImage& other, const Parallax& parallax, double inverse_depth,
                                  const PixelBox& box, int y) {
    const Eigen::Vector3f start =
        (parallax.A * Vec3(box.x0 - radius_, y, 1) + inverse_depth * parallax.b).cast<float>();
    const Eigen::Vector3f step = parallax.A.col(0).cast<float>();
    const auto right = static_cast<float>(other.width() - 1), bottom = static_cast<float>(other.height() - 1);
    const std::int32_t n_columns = other.width() - 1;
    const std::uint64_t* const patches = other.patches().data();
    const float* const reference = &reference_(box.x0, y + radius_);
    const float* const known_there = &known_(box.x0, y + radius_);
    float* const row = rows_.data() + at((y + radius_) % (2 * radius_ + 1)) * n_sums * pitch_;
    const Float8 zero{}, lanes = {0, 1, 2, 3, 4, 5, 6, 7};
    for (std::size_t i = 0; i < pitch_; i += n_lanes) {
        const Float8 along = lanes + static_cast<float>(i);
        const Float8 z = start.z() + along * step.z(), inverse_z = 1.0f / z;
        const Float8 u = (start.x() + along * step.x()) * inverse_z, v = (start.y() + along * step.y()) * inverse_z;
        const Int8 inside = (z > 0.0f) & (u >= 0.0f) & (v >= 0.0f) & (u < right) & (v < bottom);
        const Float8 px = inside ? u : zero, py = inside ? v : zero;
        const Int8 x0 = __builtin_convertvector(px, Int8), y0 = __builtin_convertvector(py, Int8);
        const Float8 fx = px - __builtin_convertvector(x0, Float8), fy = py - __builtin_convertvector(y0, Float8);
        const Int8 patch = y0 * n_columns + x0;
        std::int64_t p[n_lanes];
        for (std::size_t lane = 0; lane < n_lanes; ++lane) std::memcpy(&p[lane], patches + patch[lane], sizeof p[lane]);
        // Even and odd halves of two registers of four come as lanes 0, 1, 2, 3 and 4, 5, 6, 7 of the instruction.
        const auto front = reinterpret_cast<Int8>(Long4{p[0], p[1], p[4], p[5]});
        const auto back = reinterpret_cast<Int8>(Long4{p[2], p[3], p[6], p[7]});
        const Int8 top = __builtin_shufflevector(front, back, 0, 2, 8, 10, 4, 6, 12, 14);
        const Int8 low = __builtin_shufflevector(front, back, 1, 3, 9, 11, 5, 7, 13, 15);
        const Float8 top_left = __builtin_convertvector(top & 0xffff, Float8),
                     top_right = __builtin_convertvector(top >> 16, Float8),
                     low_left = __builtin_convertvector(low & 0xffff, Float8),
                     low_right = __builtin_convertvector(low >> 16, Float8);
        const Float8 upper = top_left + fx * (top_right - top_left), lower = low_left + fx * (low_right - low_left);
        Float8 va, known;
        load(reference + i, va);
        load(known_there + i, known);
        known = (inside & (top != -1)) ? known : zero;
        va *= known;
        const Float8 vb = ((upper + fy * (lower - upper)) * per_brightness - 1.0f) * known;
        store(known, row + Sum::count * pitch_ + i);
        store(va, row + Sum::a * pitch_ + i);
        store(va * va, row + Sum::aa * pitch_ + i);
        store(vb, row + Sum::b * pitch_ + i);
        store(vb * vb, row + Sum::bb * pitch_ + i);
        store(va * vb, row + Sum::ab * pitch_ + i);
    }
}

namespace {

// The row that `known` counts the middles of. Inlined by force, so that a side known beforehand unrolls.
[[gnu::always_inline]] inline void correlate_columns(const float* rows, std::size_t side, std::size_t pitch,
                                                     std::size_t width, const float* known, float* correlations) {
    constexpr float noise = 1.5f / 127.5f;  // a grey level and a half
    const float fewest = 0.5f * static_cast<float>(side * side);
    for (std::size_t x = 0; x < width; x += n_lanes) {
        Float8 sums[n_sums]{};
        for (std::size_t s = 0; s < n_sums; ++s)
            for (std::size_t j = 0; j < side; ++j)
                for (std::size_t k = 0; k < side; ++k) {
                    Float8 of_pixel;
                    load(rows + (j * n_sums + s) * pitch + x + k, of_pixel);
                    sums[s] += of_pixel;
                }
        const Float8 zero{}, tiny = zero + 1e-12f;
        const Float8& n = sums[Sum::count];
        // n^2 times the (co)variances; the square of the correlation needs no root.
        const Float8 floor = n * n * (noise * noise);
        const Float8 variance_a = n * sums[Sum::aa] - sums[Sum::a] * sums[Sum::a] + floor;
        const Float8 variance_b = n * sums[Sum::bb] - sums[Sum::b] * sums[Sum::b] + floor;
        Float8 covariance = n * sums[Sum::ab] - sums[Sum::a] * sums[Sum::b];
        covariance = covariance > zero ? covariance : zero;
        const Float8 product = variance_a * variance_b;
        const Float8 squared = covariance * covariance / (product > tiny ? product : tiny);
        Float8 middle;
        load(known + x, middle);
        store(((middle > zero) & (n >= fewest)) ? squared : zero, correlations + x);
    }
}

}  // namespace

ANYRATE_VECTOR_CLONES
void WindowCorrelation::correlate_row(const PixelBox& box, int y, float* correlations) {
    const std::size_t side = at(2 * radius_ + 1), width = at(box.width());
    const float* const known =
        rows_.data() + at(y + radius_) % side * n_sums * pitch_ + Sum::count * pitch_ + at(radius_);
    if (side == 3)
        correlate_columns(rows_.data(), 3, pitch_, width, known, correlations);
    else
        correlate_columns(rows_.data(), side, pitch_, width, known, correlations);
}

}  // namespace anyrate
