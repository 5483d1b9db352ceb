#include "core/reconstruction/visibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel.h"
#include "core/reconstruction/inverse_depth.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Depth maps need no more than about a thousand pixels a side: the faces are several pixels large.
constexpr int max_depth_map_side = 1024;

/// Largest of the four pixels around (x, y), which must have them: what hides most.
float nearest_around(const Image<float>& inverse_depth, float x, float y) {
    const float* top = &inverse_depth(static_cast<int>(x), static_cast<int>(y));
    const float* bottom = top + inverse_depth.width;
    return std::max(std::max(top[0], top[1]), std::max(bottom[0], bottom[1]));
}

/// A face where it stands.
struct FacePlane {
    Vec3 centroid, normal;  ///< the normal is zero if the face has no area
};

std::vector<FacePlane> face_planes(const SurfaceView& surface, std::span<const std::int32_t> faces) {
    std::vector<FacePlane> planes(faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Triangle& t = surface.triangles[at(faces[i])];
        const Vec3 &a = surface.vertices[at(t[0])], &b = surface.vertices[at(t[1])], &c = surface.vertices[at(t[2])];
        planes[i].centroid = (a + b + c) / 3.0;
        planes[i].normal = (b - a).cross(c - a);
        if (const double norm = planes[i].normal.norm(); norm > 0) planes[i].normal /= norm;
    }
    return planes;
}

/// How a view sees one of the faces asked for.
struct FaceSight {
    std::int32_t index = 0;  ///< of the face, in the list
    bool whole = false;
    float slope = 0, area_px = 0;  ///< see Visibility
};

/// The faces of the list that one view sees, in their order.
class Looker {
public:
    Looker(const PhotoView& view, int level, std::span<const ScreenVertex> vertices, const Image<float>& inverse_depth,
           const VisibilityOptions& options)
        : view_(view),
          vertices_(vertices),
          inverse_depth_(inverse_depth),
          options_(options),
          per_px_(std::ldexp(options.tolerance_px, level) / view.focal_px),
          area_scale_(std::ldexp(0.5F, 2 * level)) {}

    std::vector<FaceSight> look(std::span<const Triangle> triangles, std::span<const std::int32_t> faces,
                                std::span<const FacePlane> planes) const {
        std::vector<FaceSight> sights;
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const Vec3 to_camera = view_.centre - planes[i].centroid;
            const double along = planes[i].normal.dot(to_camera);
            if (!(along > 0)) continue;
            const double cos_theta = along / to_camera.norm();
            if (cos_theta < options_.min_cos) continue;
            FaceSight sight{static_cast<std::int32_t>(i), false, 0, 0};
            const double tan_theta = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta)) / cos_theta;
            sight.slope = static_cast<float>(per_px_ * (1.0 + tan_theta));
            if (is_seen(triangles[at(faces[i])], sight)) sights.push_back(sight);
        }
        return sights;
    }

private:
    bool is_seen(const Triangle& t, FaceSight& sight) const {
        const ScreenVertex corners[3] = {vertices_[at(t[0])], vertices_[at(t[1])], vertices_[at(t[2])]};
        const auto width = static_cast<float>(inverse_depth_.width - 1),
                   height = static_cast<float>(inverse_depth_.height - 1);
        for (const ScreenVertex& c : corners)
            if (!(c.inverse_depth > 0 && c.x >= 0 && c.y >= 0 && c.x < width && c.y < height)) return false;
        // Corners, edge middles and the centre: seven probes tell whole, partly and not at all apart. Means on the
        // screen lie on the triangle, since inverse depth is linear there.
        int n_seen = 0;
        const auto probe = [&](float x, float y, float inverse_depth) {
            n_seen += inverse_depth * (1.0F + sight.slope) >= nearest_around(inverse_depth_, x, y) ? 1 : 0;
        };
        for (int k = 0; k < 3; ++k) {
            const ScreenVertex &a = corners[k], &b = corners[(k + 1) % 3];
            probe(a.x, a.y, a.inverse_depth);
            probe(0.5F * (a.x + b.x), 0.5F * (a.y + b.y), 0.5F * (a.inverse_depth + b.inverse_depth));
        }
        const ScreenVertex &a = corners[0], &b = corners[1], &c = corners[2];
        constexpr float third = 1.0F / 3.0F;
        probe(third * (a.x + b.x + c.x), third * (a.y + b.y + c.y),
              third * (a.inverse_depth + b.inverse_depth + c.inverse_depth));
        sight.whole = n_seen == 7;
        sight.area_px = area_scale_ * std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        return n_seen > 0;
    }

    const PhotoView& view_;
    std::span<const ScreenVertex> vertices_;
    const Image<float>& inverse_depth_;
    const VisibilityOptions& options_;
    double per_px_;
    float area_scale_;
};

}  // namespace

int depth_map_level(const PhotoImages& images, int finest_level) {
    int level = std::min(finest_level, images.n_levels() - 1);
    const auto too_large = [&](int l) {
        return std::any_of(images.views.begin(), images.views.end(), [l](const PhotoView& view) {
            return std::max(view.levels[at(l)].width, view.levels[at(l)].height) > max_depth_map_side;
        });
    };
    while (level + 1 < images.n_levels() && too_large(level)) ++level;
    return level;
}

double pixel_size_at(const PhotoImages& images, const Vec3& point) {
    double squared = std::numeric_limits<double>::infinity();
    for (const PhotoView& view : images.views)
        squared = std::min(squared, (point - view.centre).squaredNorm() / (view.focal_px * view.focal_px));
    return std::sqrt(squared);
}

Visibility::Visibility(const PhotoImages& images, const SurfaceView& surface, const VisibilityOptions& options,
                       std::span<const std::int32_t> faces)
    : level_(depth_map_level(images, options.finest_level)),
      scale_(std::ldexp(1.0F, -level_)),
      inverse_depth_(images.views.size()) {
    const std::size_t n_faces = surface.triangles.size();
    std::vector<std::int32_t> all;
    if (faces.empty()) {
        all.resize(n_faces);
        std::iota(all.begin(), all.end(), 0);
        faces = all;
    }
    const std::vector<FacePlane> planes = face_planes(surface, faces);
    std::vector<std::vector<FaceSight>> by_view(images.views.size());
    parallel_for(
        by_view.size(),
        [&](std::size_t i) {
            const PhotoView& view = images.views[i];
            const PhotoLevel& level = view.levels[at(level_)];
            const std::vector<ScreenVertex> vertices = project(level, surface);
            inverse_depth_[i] = render_inverse_depth(level.width, level.height, vertices, surface.triangles);
            by_view[i] =
                Looker(view, level_, vertices, inverse_depth_[i], options).look(surface.triangles, faces, planes);
        },
        1);

    begin_.assign(n_faces + 1, 0);
    for (const auto& sights : by_view)
        for (const FaceSight& sight : sights) ++begin_[at(faces[at(sight.index)]) + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    face_views_.resize(begin_.back());
    slope_.assign(n_faces, 0.0F);
    mean_area_px_.assign(n_faces, 0.0);
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < by_view.size(); ++i)
        for (const FaceSight& sight : by_view[i]) {
            const std::size_t f = at(faces[at(sight.index)]);
            face_views_[next[f]++] = {static_cast<std::int32_t>(i), sight.whole};
            // A face that is partly hidden asks again for every sample, with the tolerance of its steepest view.
            slope_[f] = std::max(slope_[f], sight.slope);
            mean_area_px_[f] += static_cast<double>(sight.area_px);
        }
    for (std::size_t f = 0; f < n_faces; ++f)
        if (begin_[f + 1] > begin_[f]) mean_area_px_[f] /= static_cast<double>(begin_[f + 1] - begin_[f]);

    pixel_size_.assign(n_faces, 0.0);
    parallel_for(faces.size(),
                 [&](std::size_t i) { pixel_size_[at(faces[i])] = pixel_size_at(images, planes[i].centroid); });
}

ANYRATE_VECTOR_CLONES
void Visibility::look_at(std::int32_t face, std::int32_t view, const Float8& x, const Float8& y,
                         const Float8& inverse_depth, Float8& visible) const {
    const Image<float>& depths = inverse_depth_[at(view)];
    visible = Float8{};
    if (depths.width < 2 || depths.height < 2) return;
    const Float8 zero{}, px = (x + 0.5F) * scale_ - 0.5F, py = (y + 0.5F) * scale_ - 0.5F;
    const Int8 inside = (px >= 0) & (py >= 0) & (px < static_cast<float>(depths.width - 1)) &
                        (py < static_cast<float>(depths.height - 1));
    const Float8 column = inside ? px : zero, row = inside ? py : zero;
    const Int8 first = __builtin_convertvector(row, Int8) * depths.width + __builtin_convertvector(column, Int8);
    Float8 top_left, top_right, bottom_left, bottom_right;
    for (std::size_t lane = 0; lane < n_lanes; ++lane) {
        const float* const top = depths.pixels.data() + first[lane];
        top_left[lane] = top[0];
        top_right[lane] = top[1];
        bottom_left[lane] = top[depths.width];
        bottom_right[lane] = top[depths.width + 1];
    }
    const Float8 above = top_left < top_right ? top_right : top_left;
    const Float8 below = bottom_left < bottom_right ? bottom_right : bottom_left;
    const Float8 nearest = above < below ? below : above;
    visible = (inside & (inverse_depth * (1.0F + slope_[at(face)]) >= nearest)) ? zero + 1.0F : zero;
}

}  // namespace anyrate
