#include "core/reconstruction/visibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/double4.h"
#include "core/parallel.h"
#include "core/reconstruction/pixel_box.h"
#include "core/vector_clones.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Depth maps need no more than about a thousand pixels a side: the faces are several pixels large.
constexpr int max_depth_map_side = 1024;

constexpr std::size_t n_wide = 4;  ///< faces at a time

/// Faces where they stand, coordinate by coordinate; unit normals, zero if a face has no area.
struct FacePlanes {
    std::vector<double> centroid[3], normal[3];  ///< whole fours: faces without area at the end

    FacePlanes(const SurfaceView& surface, std::span<const std::int32_t> faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            centroid[k].resize((faces.size() + n_wide - 1) / n_wide * n_wide);
            normal[k].resize(centroid[k].size());
        }
        parallel_for(
            faces.size(),
            [&](std::size_t i) {
                const Triangle& t = surface.triangles[at(faces[i])];
                const Vec3 &a = surface.vertices[at(t[0])], &b = surface.vertices[at(t[1])],
                           &c = surface.vertices[at(t[2])];
                const Vec3 middle = (a + b + c) / 3.0;
                Vec3 n = (b - a).cross(c - a);
                if (const double norm = n.norm(); norm > 0) n /= norm;
                for (std::size_t k = 0; k < 3; ++k) {
                    centroid[k][i] = middle[static_cast<Eigen::Index>(k)];
                    normal[k][i] = n[static_cast<Eigen::Index>(k)];
                }
            },
            1024);
    }

    Vec3 centroid_of(std::size_t i) const { return {centroid[0][i], centroid[1][i], centroid[2][i]}; }
    Vec3 normal_of(std::size_t i) const { return {normal[0][i], normal[1][i], normal[2][i]}; }
};

/// The faces that look at the camera about as straight as they must, ascending; the caller knows it exactly.
ANYRATE_VECTOR_CLONES
void find_facing(const FacePlanes& planes, const Vec3& centre, double min_cos, std::vector<std::int32_t>& facing) {
    const std::size_t n = planes.centroid[0].size();
    facing.resize(n + 1);  // each face is written down, and taken back if it does not look here
    const double less_cos = std::max(0.0, min_cos - 1e-9), squared_cos = less_cos * less_cos;
    std::size_t n_facing = 0;
    for (std::size_t i = 0; i < n; i += n_wide) {
        Double4 along{}, squared{};
        for (std::size_t k = 0; k < 3; ++k) {
            Double4 middle, normal;
            std::memcpy(&middle, planes.centroid[k].data() + i, sizeof middle);
            std::memcpy(&normal, planes.normal[k].data() + i, sizeof normal);
            const Double4 to_camera = centre[static_cast<Eigen::Index>(k)] - middle;
            along += normal * to_camera;
            squared += to_camera * to_camera;
        }
        const Long4 faces_camera = (along > 0) & (along * along >= squared_cos * squared);
        for (std::size_t lane = 0; lane < n_wide; ++lane) {
            facing[n_facing] = static_cast<std::int32_t>(i + lane);
            n_facing += static_cast<std::size_t>(-faces_camera[lane]);
        }
    }
    facing.resize(n_facing);
}

/// How a view sees one of the faces asked for.
struct FaceSight {
    std::int32_t index = 0;  ///< of the face, in the list
    bool whole = false;
    float slope = 0, area_px = 0;  ///< see Visibility
};

/// Seven probes of a face tell whole, partly and not at all seen apart: at its corners, the middles of its edges and
/// its centre, which is the last lane, too. Means on the screen lie on the triangle, since inverse depth is linear
/// there.
struct ProbeLanes {
    Int8 column, row;
    Float8 inverse_depth;
};

ANYRATE_VECTOR_CLONES
void find_probes(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, ProbeLanes& out) {
    constexpr float third = 1.0F / 3.0F;
    constexpr Float8 parts{1, 1, 1, 0.5F, 0.5F, 0.5F, third, third};
    const Float8 x = parts * (Float8{a.x, b.x, c.x, a.x, b.x, c.x, a.x, a.x} +
                              Float8{0, 0, 0, b.x, c.x, a.x, b.x, b.x} + Float8{0, 0, 0, 0, 0, 0, c.x, c.x});
    const Float8 y = parts * (Float8{a.y, b.y, c.y, a.y, b.y, c.y, a.y, a.y} +
                              Float8{0, 0, 0, b.y, c.y, a.y, b.y, b.y} + Float8{0, 0, 0, 0, 0, 0, c.y, c.y});
    const float az = a.inverse_depth, bz = b.inverse_depth, cz = c.inverse_depth;
    out.inverse_depth = parts * (Float8{az, bz, cz, az, bz, cz, az, az} + Float8{0, 0, 0, bz, cz, az, bz, bz} +
                                 Float8{0, 0, 0, 0, 0, 0, cz, cz});
    out.column = __builtin_convertvector(x, Int8);
    out.row = __builtin_convertvector(y, Int8);
}

/// The faces of the list that one view sees, in their order.
class Looker {
public:
    Looker(const PhotoView& view, int level, std::span<const ScreenVertex> vertices, const VisibilityOptions& options)
        : view_(view),
          vertices_(vertices),
          width_(view.levels[at(level)].width),
          height_(view.levels[at(level)].height),
          options_(options),
          per_px_(std::ldexp(options.tolerance_px, level) / view.focal_px),
          area_scale_(std::ldexp(0.5F, 2 * level)) {}

    /// Those that it would see if nothing hid them.
    std::vector<FaceSight> find(std::span<const Triangle> triangles, std::span<const std::int32_t> faces,
                                const FacePlanes& planes) const {
        thread_local std::vector<std::int32_t> facing;
        find_facing(planes, view_.centre, options_.min_cos, facing);
        std::vector<FaceSight> sights;
        sights.reserve(facing.size());
        for (const std::int32_t i : facing) {
            const Vec3 to_camera = view_.centre - planes.centroid_of(at(i));
            const double along = planes.normal_of(at(i)).dot(to_camera);
            if (!(along > 0)) continue;
            const double cos_theta = along / to_camera.norm();
            if (cos_theta < options_.min_cos || !is_in_image(triangles[at(faces[at(i)])])) continue;
            const double tan_theta = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta)) / cos_theta;
            sights.push_back({i, false, static_cast<float>(per_px_ * (1.0 + tan_theta)), 0});
        }
        return sights;
    }

    /// The pixels of the depth map around some faces, as far as Visibility reaches.
    PixelBox box_around(std::span<const FaceSight> sights, std::span<const Triangle> triangles,
                        std::span<const std::int32_t> faces) const {
        std::vector<ScreenVertex> corners;
        corners.reserve(3 * sights.size());
        for (const FaceSight& sight : sights)
            for (const std::int32_t v : triangles[at(faces[at(sight.index)])]) corners.push_back(vertices_[at(v)]);
        const PixelBox box = pixels_around(corners, width_, height_);
        constexpr int reach = Visibility::reach_px + 1;  // widen_far_contours() asks one further
        return {std::max(0, box.x0 - reach), std::max(0, box.y0 - reach), std::min(width_, box.x1 + reach),
                std::min(height_, box.y1 + reach)};
    }

    /// Leaves those that it does see.
    /// @param depth  of which each pixel is the largest of four
    void look(std::span<const Triangle> triangles, std::span<const std::int32_t> faces, const InverseDepthPart& depth,
              std::vector<FaceSight>& sights) const {
        std::erase_if(sights,
                      [&](FaceSight& sight) { return !is_seen(triangles[at(faces[at(sight.index)])], depth, sight); });
    }

private:
    bool is_in_image(const Triangle& t) const {
        const auto right = static_cast<float>(width_ - 1), bottom = static_cast<float>(height_ - 1);
        return std::ranges::all_of(t, [&](std::int32_t v) {
            const ScreenVertex& p = vertices_[at(v)];
            return p.inverse_depth > 0 && p.x >= 0 && p.y >= 0 && p.x < right && p.y < bottom;
        });
    }

    bool is_seen(const Triangle& t, const InverseDepthPart& depth, FaceSight& sight) const {
        const ScreenVertex &a = vertices_[at(t[0])], &b = vertices_[at(t[1])], &c = vertices_[at(t[2])];
        ProbeLanes probes;
        find_probes(a, b, c, probes);
        const Float8 reached = probes.inverse_depth * (1.0F + sight.slope);
        int n_seen = 0;
        for (std::size_t lane = 0; lane < 7; ++lane) {
            const float hidden = depth.pixels(probes.column[lane] - depth.x, probes.row[lane] - depth.y);
            n_seen += reached[lane] >= hidden ? 1 : 0;
        }
        sight.whole = n_seen == 7;
        sight.area_px = area_scale_ * std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        return n_seen > 0;
    }

    const PhotoView& view_;
    std::span<const ScreenVertex> vertices_;
    int width_, height_;  ///< of the depth map
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

float far_part(const PhotoView& view, int level, const VisibilityOptions& options) {
    return static_cast<float>(std::max(0.0, 1 - std::ldexp(options.far_px, level) / view.focal_px));
}

double pixel_size_at(const PhotoImages& images, const Vec3& point) {
    double squared = std::numeric_limits<double>::infinity();
    for (const PhotoView& view : images.views)
        squared = std::min(squared, (point - view.centre).squaredNorm() / (view.focal_px * view.focal_px));
    return std::sqrt(squared);
}

Visibility::Visibility(const PhotoImages& images, const SurfaceView& surface, const VisibilityOptions& options,
                       std::span<const std::int32_t> faces, StandingDepth* standing)
    : level_(depth_map_level(images, options.finest_level)),
      scale_(std::ldexp(1.0F, -level_)),
      views_(images.views.size()) {
    const std::size_t n_faces = surface.triangles.size();
    std::vector<std::int32_t> all;
    const bool is_part = !faces.empty() && faces.size() < n_faces;
    if (!is_part) {
        all.resize(n_faces);
        std::iota(all.begin(), all.end(), 0);
        faces = all;
    }
    StandingDepth none;
    StandingDepth& others = standing != nullptr ? *standing : none;
    if (is_part)
        others.keep(images, level_, surface, faces);
    else
        others = {};
    const FacePlanes planes(surface, faces);
    std::vector<std::vector<FaceSight>> by_view(images.views.size());
    parallel_for(
        by_view.size(),
        [&](std::size_t i) {
            const PhotoView& view = images.views[i];
            const PhotoLevel& level = view.levels[at(level_)];
            const std::vector<ScreenVertex> vertices =
                is_part ? project(level, surface, others.moving_vertices()) : project(level, surface);
            const Looker looker(view, level_, vertices, options);
            by_view[i] = looker.find(surface.triangles, faces, planes);
            const PixelBox box = is_part ? looker.box_around(by_view[i], surface.triangles, faces)
                                         : pixels_around(vertices, level.width, level.height);
            views_[i] = {level.width, level.height, {}};
            if (box.is_empty()) return;
            views_[i].depth =
                is_part ? others.draw(i, level, box, vertices)
                        : render_inverse_depth_in(box, level.width, level.height, vertices, surface.triangles);
            widen_far_contours(views_[i].depth, far_part(view, level_, options));
            take_largest_of_four(views_[i].depth.pixels);
            looker.look(surface.triangles, faces, views_[i].depth, by_view[i]);
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
                 [&](std::size_t i) { pixel_size_[at(faces[i])] = pixel_size_at(images, planes.centroid_of(i)); });
}

ANYRATE_VECTOR_CLONES
void Visibility::look_at(std::int32_t face, std::int32_t view, const Float8& x, const Float8& y,
                         const Float8& inverse_depth, Float8& visible) const {
    const View& seen = views_[at(view)];
    const Image<float>& depths = seen.depth.pixels;
    visible = Float8{};
    if (depths.width < 2 || depths.height < 2) return;
    const Float8 zero{}, px = (x + 0.5F) * scale_ - 0.5F, py = (y + 0.5F) * scale_ - 0.5F;
    const Int8 inside =
        (px >= 0) & (py >= 0) & (px < static_cast<float>(seen.width - 1)) & (py < static_cast<float>(seen.height - 1));
    const Int8 column = __builtin_convertvector(inside ? px : zero, Int8) - seen.depth.x;
    const Int8 row = __builtin_convertvector(inside ? py : zero, Int8) - seen.depth.y;
    const Int8 is_rendered = (column >= 0) & (row >= 0) & (column < depths.width - 1) & (row < depths.height - 1);
    const Int8 first = (row * depths.width + column) & is_rendered;
    Float8 nearest;
    for (std::size_t lane = 0; lane < n_lanes; ++lane) nearest[lane] = depths.pixels[at(first[lane])];
    nearest = is_rendered ? nearest : zero;
    visible = (inside & (inverse_depth * (1.0F + slope_[at(face)]) >= nearest)) ? zero + 1.0F : zero;
}

}  // namespace anyrate
