#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/reconstruction/colour_patch.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/visibility.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// The views of one triangle, an array per quantity so that loops over views vectorise. Pixels are relative to a corner
/// of the triangle's box in each view, so that single precision resolves a thousandth of a pixel in any image.
struct TriangleInViews {
    struct Patch {
        std::int32_t view = 0;
        bool whole = false;
        std::int32_t x = 0, y = 0;             ///< of the origin, pixels of the level
        float width = 0, height = 0;           ///< from the origin to where the last bilinear patch starts
        const std::uint8_t* pixels = nullptr;  ///< at the origin
        std::ptrdiff_t row = 0;                ///< bytes
    };
    /// How the homogeneous pixel and depth of the corners move with u; a lane a corner.
    struct Motion {
        Float4 x, y, z;
    };
    std::vector<Patch> patches;
    std::vector<float> x[3], y[3], z[3];   ///< [corner]: homogeneous pixel and depth of the corner
    std::vector<Motion> motion;            ///< only if derivatives are asked for
    std::vector<float> px, py, inverse_z;  ///< of the current sample

    std::size_t size() const { return patches.size(); }

    void resize(std::size_t n) {
        patches.resize(n);
        motion.resize(n);
        for (auto* of_corner : {x, y, z})
            for (std::size_t k = 0; k < 3; ++k) of_corner[k].resize(n);
        for (auto* of_sample : {&px, &py, &inverse_z}) of_sample->resize(n);
    }

    /// Projects the sample with barycentric coordinates b into every view.
    void project(const float b[3]) {
        const std::size_t n = size();
        for (std::size_t i = 0; i < n; ++i) {
            inverse_z[i] = 1.0F / (b[0] * z[0][i] + b[1] * z[1][i] + b[2] * z[2][i]);
            px[i] = (b[0] * x[0][i] + b[1] * x[1][i] + b[2] * x[2][i]) * inverse_z[i];
            py[i] = (b[0] * y[0][i] + b[1] * y[1][i] + b[2] * y[2][i]) * inverse_z[i];
        }
    }
};

/// What one view says of one sample.
struct SampleInView {
    std::size_t view = 0;  ///< its place among the triangle's views
    ColourPatch colour;
};

/// Sums over a triangle's samples; the lanes of each are its three scalars u, or its three edges.
struct TermSums {
    double phi = 0, n_samples = 0;
    Float4 gradient{}, hessian_own{}, hessian_next{}, middle_gradient{}, middle_hessian{};
};

Float4 first_three(const float* v) { return Float4{v[0], v[1], v[2], 0.0F}; }

class CpuBackend final : public PhotoBackend {
public:
    CpuBackend(const PhotoImages& images, Sampling sampling) : images_(images), sampling_(sampling) {}

    void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                     std::span<const std::int32_t> faces) override {
        assert(level >= 0 && level < images_.n_levels());
        level_ = level;
        // A pixel of a coarse level asks for no finer depth than its own quarters.
        VisibilityOptions options;
        options.finest_level = std::max(level - 1, options.finest_level);
        visibility_ = std::make_unique<Visibility>(images_, surface, options, faces);
        const OneRings rings(surface);
        faces_.resize(surface.triangles.size());
        const double area_scale = std::ldexp(1.0, -2 * level);
        std::vector<double> areas_px(faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            areas_px[f] = visibility_->mean_area_px(static_cast<std::int32_t>(f)) * area_scale;
        const std::vector<int> steps = lattice_steps(areas_px, samples_per_px, sampling_);
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            faces_[f].steps = steps[f];
            for (std::size_t k = 0; k < 3; ++k)
                faces_[f].corner_weight[k] = 1.0 / rings.valence(surface.triangles[f][k]);
        }
    }

    std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
        std::vector<TriangleDistortion> result(batch.size());
        parallel_for(batch.size(), [&](std::size_t i) { result[i] = distortion(batch[i]); });
        return result;
    }

    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>> directions) override {
        assert(batch.size() == directions.size());
        std::vector<TriangleTerms> result(batch.size());
        parallel_for(batch.size(), [&](std::size_t i) { result[i] = triangle_terms(batch[i], directions[i]); });
        return result;
    }

    double pixel_size(std::int32_t face) const override { return std::ldexp(visibility_->pixel_size(face), level_); }
    int n_levels() const override { return images_.n_levels(); }

private:
    struct Face {
        int steps = 1;
        double corner_weight[3] = {0, 0, 0};  ///< 1 / valence
    };

    double weight(const Face& face, const LatticeSample& s) const {
        // Nghiem et al., Eq. 8: 1/valence at a vertex, 1/2 on an edge, 1 inside.
        return s.corner >= 0 ? face.corner_weight[s.corner] : s.weight;
    }

    /// Projects the triangle into the views that see it. @param directions  of its corners; nullptr if not needed
    void see(const TriangleQuery& query, const std::array<Vec3, 3>* directions, TriangleInViews& views) const {
        const std::span<const FaceView> face_views = visibility_->views(query.face);
        views.resize(face_views.size());
        for (std::size_t i = 0; i < face_views.size(); ++i) {
            const PhotoLevel& image = images_.views[at(face_views[i].view)].levels[at(level_)];
            Vec3 x[3];
            Vec2 lowest = Vec2::Constant(std::numeric_limits<double>::infinity()), highest = -lowest;
            for (std::size_t k = 0; k < 3; ++k) {
                x[k] = image.P * query.corners[k].homogeneous();
                const Vec2 pixel = x[k].hnormalized();
                lowest = lowest.cwiseMin(pixel);
                highest = highest.cwiseMax(pixel);
            }
            TriangleInViews::Patch& patch = views.patches[i];
            patch.view = face_views[i].view;
            patch.whole = face_views[i].whole;
            const auto origin = [](double lowest_px, int size) {
                return static_cast<std::int32_t>(std::clamp(std::floor(lowest_px - 0.01), 0.0, size - 1.0));
            };
            patch.x = origin(lowest.x(), image.width);
            patch.y = origin(lowest.y(), image.height);
            patch.width = static_cast<float>(image.width - 1 - patch.x);
            patch.height = static_cast<float>(image.height - 1 - patch.y);
            patch.pixels = image.pixel(patch.x, patch.y);
            patch.row = 4 * static_cast<std::ptrdiff_t>(image.width);
            prefetch(patch, highest);
            for (std::size_t k = 0; k < 3; ++k) {
                views.x[k][i] = static_cast<float>(x[k].x() - patch.x * x[k].z());
                views.y[k][i] = static_cast<float>(x[k].y() - patch.y * x[k].z());
                views.z[k][i] = static_cast<float>(x[k].z());
                if (directions == nullptr) continue;
                const Vec3 q = image.P.leftCols<3>() * (*directions)[k];
                views.motion[i].x[k] = static_cast<float>(q.x() - patch.x * q.z());
                views.motion[i].y[k] = static_cast<float>(q.y() - patch.y * q.z());
                views.motion[i].z[k] = static_cast<float>(q.z());
            }
        }
    }

    /// The samples of a triangle visit its views in turn: without a hint each row of each view is a cache miss (40 % of
    /// the time). Inlined by force, since GCC 12 drops calls of a function that does nothing but prefetch.
    [[gnu::always_inline]] static inline void prefetch(const TriangleInViews::Patch& patch, const Vec2& highest) {
        const int n_rows = static_cast<int>(std::clamp(highest.y() - patch.y + 2, 0.0, patch.height + 1.0));
        const int n_columns = static_cast<int>(std::clamp(highest.x() - patch.x + 2, 0.0, patch.width + 1.0));
        for (int j = 0; j < n_rows; ++j)
            for (int i = 0; i < n_columns; i += 16) __builtin_prefetch(patch.pixels + j * patch.row + 4 * i);
    }

    bool is_visible(std::int32_t face, const TriangleInViews& views, std::size_t i) const {
        const TriangleInViews::Patch& patch = views.patches[i];
        if (patch.whole) return true;
        const float scale = std::ldexp(1.0F, level_);
        const float x = (static_cast<float>(patch.x) + views.px[i] + 0.5F) * scale - 0.5F;
        const float y = (static_cast<float>(patch.y) + views.py[i] + 0.5F) * scale - 0.5F;
        return visibility_->is_visible(face, patch.view, x, y, views.inverse_z[i]);
    }

    /// Colours of a sample in the views that see it; they lie in `memory`.
    std::span<SampleInView> look(std::int32_t face, TriangleInViews& views, const float b[3],
                                 std::vector<SampleInView>& memory) const {
        views.project(b);
        memory.resize(std::max(memory.size(), views.size()));
        std::size_t n = 0;
        for (std::size_t i = 0; i < views.size(); ++i) {
            const TriangleInViews::Patch& patch = views.patches[i];
            const float x = views.px[i], y = views.py[i];
            if (!(views.inverse_z[i] > 0 && x >= 0 && y >= 0 && x < patch.width && y < patch.height)) continue;
            memory[n].view = i;
            n += sample_patch(patch.pixels, patch.row, x, y, memory[n].colour) && is_visible(face, views, i) ? 1U : 0U;
        }
        return {memory.data(), n};
    }

    static Float4 mean_colour(std::span<const SampleInView> samples) {
        Float4 sum{};
        for (const SampleInView& v : samples) sum += v.colour.c;
        return sum / static_cast<float>(samples.size());
    }

    TriangleDistortion distortion(const TriangleQuery& query) const {
        thread_local TriangleInViews views;
        thread_local std::vector<SampleInView> memory;
        TriangleDistortion out;
        see(query, nullptr, views);
        if (views.size() < 2) return out;
        const Face& face = faces_[at(query.face)];
        for (const LatticeSample& s : lattice(face.steps)) {
            const std::span<const SampleInView> samples = look(query.face, views, s.b_single, memory);
            if (samples.size() < 2) continue;
            const Float4 mean = mean_colour(samples);
            Float4 F{};
            for (const SampleInView& v : samples) F += (v.colour.c - mean) * (v.colour.c - mean);
            const double omega = weight(face, s);
            // Nghiem et al., Eq. 5, in the two-pass form of photo_consistency().
            out.phi += omega * sum_of_lanes(F) / (static_cast<double>(samples.size()) - 1);
            out.n_samples += omega;
        }
        return out;
    }

    TriangleTerms triangle_terms(const TriangleQuery& query, const std::array<Vec3, 3>& directions) const {
        thread_local TriangleInViews views;
        thread_local std::vector<SampleInView> memory;
        see(query, &directions, views);
        if (views.size() < 2) return {};
        TermSums sums;
        const Face& face = faces_[at(query.face)];
        for (const LatticeSample& s : lattice(face.steps)) {
            const std::span<SampleInView> samples = look(query.face, views, s.b_single, memory);
            if (samples.size() >= 2) add_sample(views, samples, s, weight(face, s), sums);
        }
        TriangleTerms out;
        out.distortion = {sums.phi, sums.n_samples};
        for (std::size_t a = 0; a < 3; ++a) {
            out.gradient[a] = static_cast<double>(sums.gradient[a]);
            out.hessian[a] = static_cast<double>(sums.hessian_own[a]);
            out.hessian[3 + a] = static_cast<double>(sums.hessian_next[a]);
            out.middle_gradient[a] = static_cast<double>(sums.middle_gradient[a]);
            out.middle_hessian[a] = static_cast<double>(sums.middle_hessian[a]);
        }
        return out;
    }

    /// F of one sample (Nghiem et al., Eq. 5) and its derivatives, into the triangle's sums. The derivative is
    /// dF/du = 2/(K-1) sum (C_i - mean C) dC_i/du; the Gauss-Newton Hessian 2/(K-1) sum (dC_i/du - mean)^2 takes one
    /// direction per sample, the barycentric mean of the three.
    static void add_sample(const TriangleInViews& views, std::span<SampleInView> samples, const LatticeSample& s,
                           double omega, TermSums& sums) {
        const auto K = static_cast<float>(samples.size());
        const Float4 mean = mean_colour(samples);
        const Float4 b = first_three(s.b_single);
        Float4 F{}, mean_slope{}, along{};  // a lane of `along` is a corner
        for (SampleInView& v : samples) {
            const Float4 residual = v.colour.c - mean;
            F += residual * residual;
            // The derivative of the projection along the directions of the corners.
            const TriangleInViews::Motion& q = views.motion[v.view];
            const float inverse_z = views.inverse_z[v.view];
            const Float4 du = (q.x - views.px[v.view] * q.z) * inverse_z;
            const Float4 dv = (q.y - views.py[v.view] * q.z) * inverse_z;
            along += sum_of_lanes(residual * v.colour.dx) * du + sum_of_lanes(residual * v.colour.dy) * dv;
            v.colour.dx = sum_of_lanes(b * du) * v.colour.dx + sum_of_lanes(b * dv) * v.colour.dy;
            mean_slope += v.colour.dx;
        }
        mean_slope /= K;
        Float4 h{};
        for (const SampleInView& v : samples) h += (v.colour.dx - mean_slope) * (v.colour.dx - mean_slope);

        const double scale = omega / (static_cast<double>(samples.size()) - 1);
        sums.phi += scale * sum_of_lanes(F);
        sums.n_samples += omega;
        const auto twice_scale = static_cast<float>(2 * scale);
        const Float4 next{b[1], b[2], b[0], 0.0F}, hat = first_three(s.middle);
        const float curvature = twice_scale * sum_of_lanes(h);
        sums.gradient += twice_scale * b * along;
        sums.hessian_own += curvature * b * b;
        sums.hessian_next += curvature * b * next;
        sums.middle_gradient += twice_scale * sum_of_lanes(b * along) * hat;
        sums.middle_hessian += curvature * hat * hat;
    }

    const PhotoImages& images_;
    Sampling sampling_;
    int level_ = 0;
    std::unique_ptr<Visibility> visibility_;
    std::vector<Face> faces_;
};

}  // namespace

std::unique_ptr<PhotoBackend> make_cpu_backend(const PhotoImages& images, Sampling sampling) {
    return std::make_unique<CpuBackend>(images, sampling);
}

}  // namespace anyrate
