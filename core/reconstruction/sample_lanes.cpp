#include "core/reconstruction/sample_lanes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <vector>

#include "core/double4.h"
#include "core/reconstruction/sampling.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::vector<SampleLanes> make_lanes(int M) {
    const std::span<const LatticeSample> samples = lattice(M);
    std::vector<SampleLanes> groups((samples.size() + n_lanes - 1) / n_lanes, SampleLanes{});
    for (std::size_t i = 0; i < groups.size() * n_lanes; ++i) {
        const LatticeSample& s = samples[std::min(i, samples.size() - 1)];
        SampleLanes& group = groups[i / n_lanes];
        const std::size_t lane = i % n_lanes;
        for (std::size_t k = 0; k < 3; ++k) group.b[k][lane] = s.b_single[k];
        if (i >= samples.size()) continue;
        group.weight[lane] = static_cast<float>(s.weight);
        for (std::size_t k = 0; k < 3; ++k) {
            group.is_corner[k][lane] = s.corner == static_cast<int>(k) ? 1.0F : 0.0F;
            group.middle[k][lane] = s.middle[k];
        }
    }
    return groups;
}

}  // namespace

std::span<const SampleLanes> lattice_lanes(int M) {
    static const auto lattices = [] {
        std::array<std::vector<SampleLanes>, max_lattice_steps + 1> all;
        for (int steps = 1; steps <= max_lattice_steps; ++steps)
            all[static_cast<std::size_t>(steps)] = make_lanes(steps);
        return all;
    }();
    assert(M >= 1 && M <= max_lattice_steps);
    return lattices[static_cast<std::size_t>(M)];
}

ANYRATE_VECTOR_CLONES
void look_at_lanes(const SampleLanes& lanes, std::span<const TriangleView> views, std::span<LanesInView> samples) {
    const Float8 b0 = lanes.b[0], b1 = lanes.b[1], b2 = lanes.b[2], zero{};
    for (std::size_t i = 0; i < views.size(); ++i) {
        const TriangleView& view = views[i];
        LanesInView& out = samples[i];
        const Float8 inverse_z = 1.0F / (b0 * view.corner_z[0] + b1 * view.corner_z[1] + b2 * view.corner_z[2]);
        const Float8 x = (b0 * view.corner_x[0] + b1 * view.corner_x[1] + b2 * view.corner_x[2]) * inverse_z;
        const Float8 y = (b0 * view.corner_y[0] + b1 * view.corner_y[1] + b2 * view.corner_y[2]) * inverse_z;
        const Int8 inside = (inverse_z > 0) & (x >= 0) & (y >= 0) & (x < view.width) & (y < view.height);
        out.inverse_z = inside ? inverse_z : zero;
        out.x = inside ? x : zero;
        out.y = inside ? y : zero;
        const Int8 x0 = __builtin_convertvector(out.x, Int8), y0 = __builtin_convertvector(out.y, Int8);
        out.offset = (y0 * view.row + 4 * x0) | ~inside;
    }
    static constexpr std::uint8_t nothing[8] = {};
    for (std::size_t i = 0; i < views.size(); ++i) {
        const TriangleView& view = views[i];
        LanesInView& out = samples[i];
        std::int64_t top[n_lanes], bottom[n_lanes];  // two pixels each
        for (std::size_t lane = 0; lane < n_lanes; ++lane) {
            const std::int32_t offset = out.offset[lane];
            const std::uint8_t* from = offset < 0 ? nothing : view.pixels + offset;
            std::memcpy(&top[lane], from, 8);
            std::memcpy(&bottom[lane], offset < 0 ? nothing : from + view.row, 8);
        }
        // Even and odd halves of two registers of four come as lanes 0, 1, 2, 3 and 4, 5, 6, 7 of the instruction.
        const auto top_front = reinterpret_cast<Int8>(Long4{top[0], top[1], top[4], top[5]});
        const auto top_back = reinterpret_cast<Int8>(Long4{top[2], top[3], top[6], top[7]});
        const auto bottom_front = reinterpret_cast<Int8>(Long4{bottom[0], bottom[1], bottom[4], bottom[5]});
        const auto bottom_back = reinterpret_cast<Int8>(Long4{bottom[2], bottom[3], bottom[6], bottom[7]});
        const Int8 a = __builtin_shufflevector(top_front, top_back, 0, 2, 8, 10, 4, 6, 12, 14);
        const Int8 b = __builtin_shufflevector(top_front, top_back, 1, 3, 9, 11, 5, 7, 13, 15);
        const Int8 c = __builtin_shufflevector(bottom_front, bottom_back, 0, 2, 8, 10, 4, 6, 12, 14);
        const Int8 d = __builtin_shufflevector(bottom_front, bottom_back, 1, 3, 9, 11, 5, 7, 13, 15);
        const Int8 is_object = (a & b & c & d) < 0;  // alpha is 255 or 0
        out.seen = is_object ? zero + 1.0F : zero;
        const Float8 u = out.x - __builtin_convertvector(__builtin_convertvector(out.x, Int8), Float8);
        const Float8 v = out.y - __builtin_convertvector(__builtin_convertvector(out.y, Int8), Float8);
        for (int k = 0; k < 3; ++k) {
            const Float8 ak = __builtin_convertvector((a >> 8 * k) & 255, Float8);
            const Float8 bk = __builtin_convertvector((b >> 8 * k) & 255, Float8);
            const Float8 ck = __builtin_convertvector((c >> 8 * k) & 255, Float8);
            const Float8 dk = __builtin_convertvector((d >> 8 * k) & 255, Float8);
            const Float8 left = ck - ak, right = dk - bk, on_left = ak + v * left;
            out.dy[k] = left + u * (right - left);
            out.dx[k] = (bk - ak) + v * (right - left);
            out.colour[k] = on_left + u * ((bk + v * right) - on_left);
        }
    }
}

namespace {

/// What the views that see a sample have in common.
struct LaneMeans {
    Float8 colour[3]{};
    Float8 inverse_n{};        ///< 1 / K
    Float8 weight{}, scale{};  ///< omega and omega / (K - 1) where two views see the sample, else 0
};

[[gnu::always_inline]] inline void means_of(const Float8& weight, std::span<const LanesInView> samples,
                                            LaneMeans& means) {
    const Float8 zero{}, one = zero + 1.0F;
    Float8 n{};
    for (const LanesInView& s : samples) {
        n += s.seen;
        for (std::size_t k = 0; k < 3; ++k) means.colour[k] += s.seen * s.colour[k];
    }
    means.inverse_n = 1.0F / (n > 1 ? n : one);
    for (Float8& colour : means.colour) colour *= means.inverse_n;
    means.weight = n > 1 ? weight : zero;
    means.scale = means.weight / (n > 1 ? n - 1.0F : one);
}

}  // namespace

ANYRATE_VECTOR_CLONES
void add_distortion(const Float8& weight, std::span<const LanesInView> samples, TermLanes& sums) {
    LaneMeans means;
    means_of(weight, samples, means);
    Float8 F{};
    for (const LanesInView& s : samples) {
        Float8 squared{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Float8 residual = s.colour[k] - means.colour[k];
            squared += residual * residual;
        }
        F += s.seen * squared;
    }
    sums.phi += means.scale * F;
    sums.n_samples += means.weight;
}

ANYRATE_VECTOR_CLONES
void add_terms(const SampleLanes& lanes, const Float8& weight, std::span<const TriangleView> views,
               std::span<LanesInView> samples, TermLanes& sums) {
    LaneMeans means;
    means_of(weight, samples, means);
    const Float8 b0 = lanes.b[0], b1 = lanes.b[1], b2 = lanes.b[2];
    Float8 F{}, mean_slope[3]{}, along[3]{};
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const TriangleView& view = views[i];
        LanesInView& s = samples[i];
        Float8 squared{}, rx{}, ry{};  // residuals against the derivatives by the pixel
        for (std::size_t k = 0; k < 3; ++k) {
            const Float8 residual = s.colour[k] - means.colour[k];
            squared += residual * residual;
            rx += residual * s.dx[k];
            ry += residual * s.dy[k];
        }
        F += s.seen * squared;
        // The derivative of the projection along the directions of the corners.
        Float8 du[3], dv[3];
        for (std::size_t a = 0; a < 3; ++a) {
            du[a] = (view.motion_x[a] - s.x * view.motion_z[a]) * s.inverse_z;
            dv[a] = (view.motion_y[a] - s.y * view.motion_z[a]) * s.inverse_z;
            along[a] += s.seen * (rx * du[a] + ry * dv[a]);
        }
        const Float8 u = b0 * du[0] + b1 * du[1] + b2 * du[2], v = b0 * dv[0] + b1 * dv[1] + b2 * dv[2];
        for (std::size_t k = 0; k < 3; ++k) {
            s.dx[k] = u * s.dx[k] + v * s.dy[k];
            mean_slope[k] += s.seen * s.dx[k];
        }
    }
    for (Float8& slope : mean_slope) slope *= means.inverse_n;
    Float8 h{};
    for (const LanesInView& s : samples) {
        Float8 squared{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Float8 residual = s.dx[k] - mean_slope[k];
            squared += residual * residual;
        }
        h += s.seen * squared;
    }
    sums.phi += means.scale * F;
    sums.n_samples += means.weight;
    const Float8 twice_scale = 2.0F * means.scale;
    const Float8 curvature = twice_scale * h;
    const Float8 slope = twice_scale * (b0 * along[0] + b1 * along[1] + b2 * along[2]);
    for (std::size_t a = 0; a < 3; ++a) {
        sums.gradient[a] += twice_scale * lanes.b[a] * along[a];
        sums.hessian_own[a] += curvature * lanes.b[a] * lanes.b[a];
        sums.hessian_next[a] += curvature * lanes.b[a] * lanes.b[(a + 1) % 3];
        sums.middle_gradient[a] += slope * lanes.middle[a];
        sums.middle_hessian[a] += curvature * lanes.middle[a] * lanes.middle[a];
    }
}

double sum_of_lanes(const Float8& lanes) {
    double sum = 0;
    for (std::size_t i = 0; i < n_lanes; ++i) sum += static_cast<double>(lanes[i]);
    return sum;
}

}  // namespace anyrate
