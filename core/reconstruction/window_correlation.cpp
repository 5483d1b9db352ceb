#include "core/reconstruction/window_correlation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

// What is summed over a window, a being the reference and b the other view: 1, a, a^2, b, b^2, a b.
enum Sum : std::size_t { count, a, aa, b, bb, ab, n_sums };

}  // namespace

WindowCorrelation::WindowCorrelation(const Image<float>& reference, int radius)
    : radius_(radius),
      reference_(reference.width + 2 * radius, reference.height + 2 * radius, unknown),
      correlation_(reference.width, reference.height) {
    for (int y = 0; y < reference.height; ++y)
        std::copy_n(&reference.pixels[at(y) * at(reference.width)], reference.width, &reference_(radius, y + radius));
}

const Image<float>& WindowCorrelation::correlate(const Image<float>& other, const Parallax& parallax,
                                                 double inverse_depth, const PixelBox& box) {
    const int n_rows = 2 * radius_ + 1;
    pitch_ = at(box.x1 - box.x0 + 2 * radius_);
    carried_.resize(pitch_);
    rows_.assign(n_sums * pitch_ * at(n_rows), 0.0f);
    columns_.assign(n_sums * pitch_, 0.0f);
    window_.resize(n_sums * at(box.x1 - box.x0));
    for (int y = box.y0 - radius_; y < box.y1 + radius_; ++y) {
        const int slot = (y - box.y0 + radius_) % n_rows;
        carry_row(other, parallax, inverse_depth, box, y);
        enter_row(box, y, at(slot));
        if (y >= box.y0 + radius_) correlate_row(box, y - radius_, at((slot + n_rows - radius_) % n_rows));
    }
    return correlation_;
}

// Bilinear, along the row; unknown where any of the four pixels is. Without branches, so that it vectorises.
ANYRATE_VECTOR_CLONES
void WindowCorrelation::carry_row(const Image<float>& other, const Parallax& parallax, double inverse_depth,
                                  const PixelBox& box, int y) {
    const Eigen::Vector3f start =
        (parallax.A * Vec3(box.x0 - radius_, y, 1) + inverse_depth * parallax.b).cast<float>();
    const Eigen::Vector3f step = parallax.A.col(0).cast<float>();
    const auto right = static_cast<float>(other.width - 1), bottom = static_cast<float>(other.height - 1);
    const int row = other.width, n = static_cast<int>(pitch_);
    const float* const pixels = other.pixels.data();
    float* const carried = carried_.data();
    ANYRATE_INDEPENDENT_ITERATIONS  // the row carried is not among the pixels
    for (int i = 0; i < n; ++i) {
        const auto along = static_cast<float>(i);
        const float z = start.z() + along * step.z(), inverse_z = 1.0f / z;
        const float u = (start.x() + along * step.x()) * inverse_z, v = (start.y() + along * step.y()) * inverse_z;
        const bool inside = (z > 0.0f) & (u >= 0.0f) & (v >= 0.0f) & (u < right) & (v < bottom);
        const float px = inside ? u : 0.0f, py = inside ? v : 0.0f;
        const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
        const float fx = px - static_cast<float>(x0), fy = py - static_cast<float>(y0);
        const int p = y0 * row + x0;
        const float upper = pixels[p] + fx * (pixels[p + 1] - pixels[p]);
        const float lower = pixels[p + row] + fx * (pixels[p + row + 1] - pixels[p + row]);
        carried[i] = upper + fy * (lower - upper) + (inside ? 0.0f : unknown);
    }
}

// Replaces the oldest row in the sums over columns.
ANYRATE_VECTOR_CLONES
void WindowCorrelation::enter_row(const PixelBox& box, int y, std::size_t slot) {
    float* row = rows_.data() + slot * n_sums * pitch_;
    for (std::size_t i = 0; i < n_sums * pitch_; ++i) columns_[i] -= row[i];
    const float *reference = &reference_(box.x0, y + radius_), *carried = carried_.data();
    ANYRATE_INDEPENDENT_ITERATIONS  // the six sums do not overlap
    for (std::size_t i = 0; i < pitch_; ++i) {
        const float ri = reference[i], ci = carried[i];
        const bool known = (ri == ri) & (ci == ci);  // neither is NaN
        const float va = known ? ri : 0.0f, vb = known ? ci : 0.0f;
        row[Sum::count * pitch_ + i] = known ? 1.0f : 0.0f;
        row[Sum::a * pitch_ + i] = va;
        row[Sum::aa * pitch_ + i] = va * va;
        row[Sum::b * pitch_ + i] = vb;
        row[Sum::bb * pitch_ + i] = vb * vb;
        row[Sum::ab * pitch_ + i] = va * vb;
    }
    for (std::size_t i = 0; i < n_sums * pitch_; ++i) columns_[i] += row[i];
}

ANYRATE_VECTOR_CLONES
void WindowCorrelation::correlate_row(const PixelBox& box, int y, std::size_t middle_slot) {
    const std::size_t width = at(box.x1 - box.x0), side = at(2 * radius_ + 1);
    for (std::size_t s = 0; s < n_sums; ++s) {
        const float* column = columns_.data() + s * pitch_;
        float* sum = window_.data() + s * width;
        std::copy_n(column, width, sum);
        for (std::size_t k = 1; k < side; ++k)
            for (std::size_t x = 0; x < width; ++x) sum[x] += column[x + k];
    }
    constexpr float noise = 1.5f / 127.5f;  // a grey level and a half
    const float fewest = 0.5f * static_cast<float>(side * side);
    const float* sums = window_.data();
    const float* known = rows_.data() + middle_slot * n_sums * pitch_ + Sum::count * pitch_ + radius_;
    float* out = &correlation_(box.x0, y);
    for (std::size_t x = 0; x < width; ++x) {
        const float n = sums[Sum::count * width + x];
        const float sum_a = sums[Sum::a * width + x], sum_b = sums[Sum::b * width + x];
        // n^2 times the (co)variances; the square of the correlation needs no root, which would not vectorise.
        const float floor = n * n * noise * noise;
        const float variance_a = n * sums[Sum::aa * width + x] - sum_a * sum_a + floor;
        const float variance_b = n * sums[Sum::bb * width + x] - sum_b * sum_b + floor;
        const float covariance = std::max(n * sums[Sum::ab * width + x] - sum_a * sum_b, 0.0f);
        const float squared = covariance * covariance / std::max(variance_a * variance_b, 1e-12f);
        out[x] = known[x] > 0.0f && n >= fewest ? squared : 0.0f;
    }
}

}  // namespace anyrate
