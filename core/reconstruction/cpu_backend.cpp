#include <Eigen/Geometry>
#include <cassert>

#include "core/parallel.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/photo_consistency.h"
#include "core/reconstruction/visibility.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A view of one triangle: its corners, homogeneous, at the sampled level and at level 0, and how they move with u.
struct TriangleInView {
    std::int32_t view = 0;
    bool whole = false;
    const PhotoLevel* image = nullptr;
    Vec3 x[3];         ///< P [corner; 1] at the sampled level
    Vec3 x_finest[3];  ///< at level 0, for the depth test; only if not whole
    Vec3 q[3];         ///< P [direction; 0]
};

/// What one view says of one sample: colour, and its derivative by the three scalars u (before the barycentric weight).
struct SampleInView {
    float c[3];
    float d[3][3];  ///< [corner][channel]
};

class CpuBackend final : public PhotoBackend {
public:
    CpuBackend(const PhotoImages& images, Sampling sampling) : images_(images), sampling_(sampling) {}

    void set_surface(const SurfaceView& surface, int level, double samples_per_px) override {
        assert(level >= 0 && level < images_.n_levels());
        level_ = level;
        visibility_ = std::make_unique<Visibility>(images_, surface);
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

    void see(const TriangleQuery& query, std::vector<TriangleInView>& views) const {
        views.clear();
        for (const FaceView& face_view : visibility_->views(query.face)) {
            const PhotoView& photo = images_.views[at(face_view.view)];
            TriangleInView& v = views.emplace_back();
            v.view = face_view.view;
            v.whole = face_view.whole;
            v.image = &photo.levels[at(level_)];
            for (std::size_t k = 0; k < 3; ++k) {
                v.x[k] = v.image->P * query.corners[k].homogeneous();
                if (!v.whole) v.x_finest[k] = photo.levels.front().P * query.corners[k].homogeneous();
            }
        }
    }

    /// Whether the sample is seen, and if so its pixel at the level.
    bool sees(const TriangleQuery& query, const TriangleInView& v, const LatticeSample& s, Vec3& x) const {
        x = s.b[0] * v.x[0] + s.b[1] * v.x[1] + s.b[2] * v.x[2];
        if (x.z() <= 0) return false;
        if (v.whole) return true;
        const Vec3 x_finest = s.b[0] * v.x_finest[0] + s.b[1] * v.x_finest[1] + s.b[2] * v.x_finest[2];
        return visibility_->is_visible(query.face, v.view, x_finest);
    }

    TriangleDistortion distortion(const TriangleQuery& query) const {
        thread_local std::vector<TriangleInView> views;
        thread_local std::vector<PointColour> colours;
        TriangleDistortion out;
        see(query, views);
        if (views.size() < 2) return out;
        const Face& face = faces_[at(query.face)];
        for (const LatticeSample& s : lattice(face.steps)) {
            colours.clear();
            for (const TriangleInView& v : views) {
                Vec3 x;
                ColourSample c;
                if (sees(query, v, s, x) && sample_colour(*v.image, x.x() / x.z(), x.y() / x.z(), c))
                    colours.push_back({{c.c[0], c.c[1], c.c[2]}});
            }
            if (colours.size() < 2) continue;
            const double omega = weight(face, s);
            out.phi += omega * photo_consistency(colours);
            out.n_samples += omega;
        }
        return out;
    }

    TriangleTerms triangle_terms(const TriangleQuery& query, const std::array<Vec3, 3>& directions) const {
        thread_local std::vector<TriangleInView> views;
        thread_local std::vector<SampleInView> samples;
        TriangleTerms out;
        see(query, views);
        if (views.size() < 2) return out;
        for (TriangleInView& v : views)
            for (std::size_t k = 0; k < 3; ++k) v.q[k] = v.image->P.leftCols<3>() * directions[k];
        const Face& face = faces_[at(query.face)];
        for (const LatticeSample& s : lattice(face.steps)) {
            samples.clear();
            for (const TriangleInView& v : views) {
                Vec3 x;
                ColourSample c;
                if (!sees(query, v, s, x)) continue;
                const double inverse_z = 1.0 / x.z(), px = x.x() * inverse_z, py = x.y() * inverse_z;
                if (!sample_colour(*v.image, px, py, c)) continue;
                SampleInView& out_view = samples.emplace_back();
                for (int k = 0; k < 3; ++k) out_view.c[k] = c.c[k];
                for (int a = 0; a < 3; ++a) {
                    // The derivative of the projection along the direction of corner a.
                    const auto du = static_cast<float>((v.q[a].x() - px * v.q[a].z()) * inverse_z);
                    const auto dv = static_cast<float>((v.q[a].y() - py * v.q[a].z()) * inverse_z);
                    for (int k = 0; k < 3; ++k) out_view.d[a][k] = c.dx[k] * du + c.dy[k] * dv;
                }
            }
            if (samples.size() >= 2) add_sample(samples, s, weight(face, s), out);
        }
        return out;
    }

    /// F of one sample (Nghiem et al., Eq. 5) and its derivatives, into the triangle's sums. The derivative is
    /// dF/du = 2/(K-1) sum (C_i - mean C) dC_i/du; the Gauss-Newton Hessian 2/(K-1) sum (dC_i/du - mean)^2 takes one
    /// direction per sample, the barycentric mean of the three.
    static void add_sample(std::span<const SampleInView> samples, const LatticeSample& s, double omega,
                           TriangleTerms& out) {
        const auto K = static_cast<float>(samples.size());
        float F = 0, h = 0, r[3] = {0, 0, 0};
        const float b[3] = {static_cast<float>(s.b[0]), static_cast<float>(s.b[1]), static_cast<float>(s.b[2])};
        for (int k = 0; k < 3; ++k) {
            float mean_c = 0, mean_d = 0;
            for (const SampleInView& v : samples) {
                mean_c += v.c[k];
                mean_d += b[0] * v.d[0][k] + b[1] * v.d[1][k] + b[2] * v.d[2][k];
            }
            mean_c /= K;
            mean_d /= K;
            for (const SampleInView& v : samples) {
                const float residual = v.c[k] - mean_c;
                const float slope = b[0] * v.d[0][k] + b[1] * v.d[1][k] + b[2] * v.d[2][k] - mean_d;
                F += residual * residual;
                h += slope * slope;
                for (int a = 0; a < 3; ++a) r[a] += residual * v.d[a][k];
            }
        }
        const double scale = omega / (K - 1);
        out.distortion.phi += scale * F;
        out.distortion.n_samples += omega;
        const double mean_r = s.b[0] * r[0] + s.b[1] * r[1] + s.b[2] * r[2];
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t c = (a + 1) % 3;
            out.gradient[a] += 2 * scale * s.b[a] * r[a];
            out.hessian[a] += 2 * scale * h * s.b[a] * s.b[a];
            out.hessian[3 + a] += 2 * scale * h * s.b[a] * s.b[c];
            const double hat = middle_hat(s, a);
            out.middle_gradient[a] += 2 * scale * hat * mean_r;
            out.middle_hessian[a] += 2 * scale * h * hat * hat;
        }
    }

    /// Value at a sample of the hat function that the middle of edge (a, a + 1) gets by a 1-to-4 split.
    static double middle_hat(const LatticeSample& s, std::size_t a) {
        const double first = s.b[a], second = s.b[(a + 1) % 3], opposite = s.b[(a + 2) % 3];
        if (opposite >= 0.5) return 0.0;
        if (first >= 0.5) return 2 * second;
        if (second >= 0.5) return 2 * first;
        return 1 - 2 * opposite;
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
