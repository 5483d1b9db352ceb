#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/double4.h"
#include "core/parallel.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/sample_lanes.h"
#include "core/reconstruction/visibility.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Three points or directions, a lane each; the last lane is the third again.
struct CornerLanes {
    Double4 x, y, z;

    explicit CornerLanes(const std::array<Vec3, 3>& corners) {
        for (std::size_t lane = 0; lane < 4; ++lane) {
            const Vec3& corner = corners[std::min<std::size_t>(lane, 2)];
            x[lane] = corner.x();
            y[lane] = corner.y();
            z[lane] = corner.z();
        }
    }
};

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
        visibility_.reset();  // before the next one takes as much memory
        visibility_ = std::make_unique<Visibility>(images_, surface, options, faces, &standing_);
        if (!std::ranges::equal(triangles_, surface.triangles)) weigh_corners(surface);
        const double area_scale = std::ldexp(1.0, -2 * level);
        std::vector<double> areas_px(faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            areas_px[f] = visibility_->mean_area_px(static_cast<std::int32_t>(f)) * area_scale;
        const std::vector<int> steps = lattice_steps(areas_px, samples_per_px, sampling_);
        for (std::size_t f = 0; f < faces_.size(); ++f) faces_[f].steps = steps[f];
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
    const Visibility* visibility() const override { return visibility_.get(); }

private:
    struct Face {
        int steps = 1;
        float corner_weight[3] = {0, 0, 0};  ///< 1 / valence
    };

    /// Of a mesh that has other faces than the last one.
    void weigh_corners(const SurfaceView& surface) {
        triangles_.assign(surface.triangles.begin(), surface.triangles.end());
        faces_.resize(triangles_.size());
        const OneRings rings(surface);
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
                faces_[f].corner_weight[k] = 1.0F / static_cast<float>(rings.valence(triangles_[f][k]));
    }

    /// Nghiem et al., Eq. 8: 1/valence at a vertex, 1/2 on an edge, 1 inside.
    static void weigh(const Face& face, const SampleLanes& lanes, Float8& weight) {
        weight = lanes.weight;
        for (std::size_t k = 0; k < 3; ++k) weight += face.corner_weight[k] * lanes.is_corner[k];
    }

    /// The triangle in the views that see it. @param directions  of its corners; nullptr if not needed
    ANYRATE_VECTOR_CLONES
    void see(const TriangleQuery& query, const std::array<Vec3, 3>* directions,
             std::vector<TriangleView>& views) const {
        const std::span<const FaceView> face_views = visibility_->views(query.face);
        views.resize(face_views.size());
        const CornerLanes corners(query.corners), motions(directions != nullptr ? *directions : query.corners);
        const auto store = [](const Double4& lanes, float(&to)[3]) {
            for (std::size_t k = 0; k < 3; ++k) to[k] = static_cast<float>(lanes[k]);
        };
        for (std::size_t i = 0; i < face_views.size(); ++i) {
            const PhotoLevel& image = images_.views[at(face_views[i].view)].levels[at(level_)];
            const Mat34& P = image.P;
            const Double4 x = P(0, 0) * corners.x + P(0, 1) * corners.y + P(0, 2) * corners.z + P(0, 3);
            const Double4 y = P(1, 0) * corners.x + P(1, 1) * corners.y + P(1, 2) * corners.z + P(1, 3);
            const Double4 z = P(2, 0) * corners.x + P(2, 1) * corners.y + P(2, 2) * corners.z + P(2, 3);
            const Double4 u = x / z, v = y / z;
            TriangleView& view = views[i];
            view.view = face_views[i].view;
            view.whole = face_views[i].whole;
            const auto origin = [](double lowest_px, int size) {
                return static_cast<std::int32_t>(std::clamp(lowest_px - 0.01, 0.0, size - 1.0));
            };
            view.x = origin(std::min({u[0], u[1], u[2]}), image.width);
            view.y = origin(std::min({v[0], v[1], v[2]}), image.height);
            view.width = static_cast<float>(image.width - 1 - view.x);
            view.height = static_cast<float>(image.height - 1 - view.y);
            view.pixels = image.pixel(view.x, view.y);
            view.row = 4 * image.width;
            prefetch(view, {std::max({u[0], u[1], u[2]}), std::max({v[0], v[1], v[2]})});
            store(x - view.x * z, view.corner_x);
            store(y - view.y * z, view.corner_y);
            store(z, view.corner_z);
            if (directions == nullptr) continue;
            const Double4 dx = P(0, 0) * motions.x + P(0, 1) * motions.y + P(0, 2) * motions.z;
            const Double4 dy = P(1, 0) * motions.x + P(1, 1) * motions.y + P(1, 2) * motions.z;
            const Double4 dz = P(2, 0) * motions.x + P(2, 1) * motions.y + P(2, 2) * motions.z;
            store(dx - view.x * dz, view.motion_x);
            store(dy - view.y * dz, view.motion_y);
            store(dz, view.motion_z);
        }
    }

    /// The samples of a triangle visit its views in turn: without a hint each row of each view is a cache miss (40 % of
    /// the time). Inlined by force, since GCC 12 drops calls of a function that does nothing but prefetch.
    [[gnu::always_inline]] static inline void prefetch(const TriangleView& view, const Vec2& highest) {
        const int n_rows = static_cast<int>(std::clamp(highest.y() - view.y + 2, 0.0, view.height + 1.0));
        const int n_columns = static_cast<int>(std::clamp(highest.x() - view.x + 2, 0.0, view.width + 1.0));
        for (int j = 0; j < n_rows; ++j)
            for (int i = 0; i < n_columns; i += 16) __builtin_prefetch(view.pixels + j * view.row + 4 * i);
    }

    /// Takes back the lanes that a view which sees the face only in part does not see.
    void hide(std::int32_t face, std::span<const TriangleView> views, std::span<LanesInView> samples) const {
        const float scale = std::ldexp(1.0F, level_);
        for (std::size_t i = 0; i < views.size(); ++i) {
            const TriangleView& view = views[i];
            if (view.whole) continue;
            LanesInView& s = samples[i];
            const Float8 x = (static_cast<float>(view.x) + s.x + 0.5F) * scale - 0.5F;
            const Float8 y = (static_cast<float>(view.y) + s.y + 0.5F) * scale - 0.5F;
            Float8 visible;
            visibility_->look_at(face, view.view, x, y, s.inverse_z, visible);
            s.seen *= visible;
        }
    }

    /// Calls add(lanes, weight, views, samples) for the samples of the triangle, eight at a time.
    template <typename Add>
    void for_each_lanes(const TriangleQuery& query, const std::array<Vec3, 3>* directions, const Add& add) const {
        thread_local std::vector<TriangleView> views;
        thread_local std::vector<LanesInView> samples;
        see(query, directions, views);
        if (views.size() < 2) return;
        samples.resize(std::max(samples.size(), views.size()));
        const std::span<LanesInView> in_views(samples.data(), views.size());
        const Face& face = faces_[at(query.face)];
        for (const SampleLanes& lanes : lattice_lanes(face.steps)) {
            look_at_lanes(lanes, views, in_views);
            hide(query.face, views, in_views);
            Float8 weight;
            weigh(face, lanes, weight);
            add(lanes, weight, views, in_views);
        }
    }

    TriangleDistortion distortion(const TriangleQuery& query) const {
        TermLanes sums;
        for_each_lanes(query, nullptr, [&](const auto&, const Float8& weight, const auto&, const auto& samples) {
            add_distortion(weight, samples, sums);
        });
        return {sum_of_lanes(sums.phi), sum_of_lanes(sums.n_samples)};
    }

    TriangleTerms triangle_terms(const TriangleQuery& query, const std::array<Vec3, 3>& directions) const {
        TermLanes sums;
        for_each_lanes(query, &directions,
                       [&](const SampleLanes& lanes, const Float8& weight, const auto& views, const auto& samples) {
                           add_terms(lanes, weight, views, samples, sums);
                       });
        TriangleTerms out;
        out.distortion = {sum_of_lanes(sums.phi), sum_of_lanes(sums.n_samples)};
        for (std::size_t a = 0; a < 3; ++a) {
            out.gradient[a] = sum_of_lanes(sums.gradient[a]);
            out.hessian[a] = sum_of_lanes(sums.hessian_own[a]);
            out.hessian[3 + a] = sum_of_lanes(sums.hessian_next[a]);
            out.middle_gradient[a] = sum_of_lanes(sums.middle_gradient[a]);
            out.middle_hessian[a] = sum_of_lanes(sums.middle_hessian[a]);
        }
        return out;
    }

    const PhotoImages& images_;
    Sampling sampling_;
    int level_ = 0;
    std::unique_ptr<Visibility> visibility_;
    StandingDepth standing_;
    std::vector<Triangle> triangles_;  ///< of the last surface
    std::vector<Face> faces_;
};

}  // namespace

std::unique_ptr<PhotoBackend> make_cpu_backend(const PhotoImages& images, Sampling sampling) {
    return std::make_unique<CpuBackend>(images, sampling);
}

}  // namespace anyrate
