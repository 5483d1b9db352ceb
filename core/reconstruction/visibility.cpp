#include "core/reconstruction/visibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int max_depth_map_side = 1024;

/// Depth maps need no more than about a thousand pixels a side: the faces are several pixels large.
int depth_level(const PhotoImages& images) {
    int level = 0;
    const auto too_large = [&](int l) {
        return std::any_of(images.views.begin(), images.views.end(), [l](const PhotoView& view) {
            return std::max(view.levels[at(l)].width, view.levels[at(l)].height) > max_depth_map_side;
        });
    };
    while (level + 1 < images.n_levels() && too_large(level)) ++level;
    return level;
}

double twice_signed_area(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Draws one triangle into an image of inverse depths, the largest of which is the nearest. 1/z is linear on the
/// screen. Faces that look away are left out: the nearest part of a closed surface always looks at the camera.
void rasterise(const Vec3& a, const Vec3& b, const Vec3& c, Image<float>& inverse_depth) {
    if (a.z() <= 0 || b.z() <= 0 || c.z() <= 0) return;
    const Vec2 p[3] = {a.hnormalized(), b.hnormalized(), c.hnormalized()};
    // Counter-clockwise from outside is clockwise in an image whose y runs down.
    const double area = twice_signed_area(p[0], p[1], p[2]);
    if (area >= 0) return;
    const auto [x_min, x_max] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [y_min, y_max] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    if (!(x_max >= 0 && y_max >= 0 && x_min <= inverse_depth.width - 1 && y_min <= inverse_depth.height - 1)) return;
    const int i0 = static_cast<int>(std::ceil(std::max(x_min, 0.0)));
    const int i1 = static_cast<int>(std::floor(std::min(x_max, inverse_depth.width - 1.0)));
    const int j0 = static_cast<int>(std::ceil(std::max(y_min, 0.0)));
    const int j1 = static_cast<int>(std::floor(std::min(y_max, inverse_depth.height - 1.0)));
    if (i0 > i1 || j0 > j1) return;

    // Barycentric coordinates and 1/z as linear functions of the pixel, stepped along the rows.
    const double per_area = 1.0 / area;
    const double u_x = (p[1].y() - p[2].y()) * per_area, u_y = (p[2].x() - p[1].x()) * per_area;
    const double v_x = (p[2].y() - p[0].y()) * per_area, v_y = (p[0].x() - p[2].x()) * per_area;
    const double za = 1.0 / a.z(), zb = 1.0 / b.z(), zc = 1.0 / c.z();
    const double z_x = (za - zc) * u_x + (zb - zc) * v_x;
    for (int j = j0; j <= j1; ++j) {
        const Vec2 from_c(i0 - p[2].x(), j - p[2].y());
        double u = u_x * from_c.x() + u_y * from_c.y();
        double v = v_x * from_c.x() + v_y * from_c.y();
        double inverse_z = zc + (za - zc) * u + (zb - zc) * v;
        float* pixel = &inverse_depth(i0, j);
        for (int i = i0; i <= i1; ++i, u += u_x, v += v_x, inverse_z += z_x, ++pixel)
            if (u >= 0 && v >= 0 && u + v <= 1) *pixel = std::max(*pixel, static_cast<float>(inverse_z));
    }
}

}  // namespace

Image<float> render_depth(const PhotoLevel& level, const SurfaceView& surface) {
    Image<float> depth(level.width, level.height, 0.0F);
    std::vector<Vec3> projected(surface.vertices.size());
    for (std::size_t v = 0; v < projected.size(); ++v) projected[v] = level.P * surface.vertices[v].homogeneous();
    for (const Triangle& t : surface.triangles)
        rasterise(projected[at(t[0])], projected[at(t[1])], projected[at(t[2])], depth);
    for (float& d : depth.pixels) d = d > 0 ? 1.0F / d : std::numeric_limits<float>::infinity();
    return depth;
}

struct Visibility::FaceSight {
    FaceView view;
    float slope;
};

Visibility::Visibility(const PhotoImages& images, const SurfaceView& surface, const VisibilityOptions& options)
    : images_(&images), options_(options), level_(depth_level(images)), scale_(std::ldexp(1.0F, -level_)) {
    depth_.resize(images.views.size());
    parallel_for(
        depth_.size(), [&](std::size_t i) { depth_[i] = render_depth(images.views[i].levels[at(level_)], surface); },
        1);

    const std::size_t n_faces = surface.triangles.size();
    slope_.assign(n_faces, 0.0F);
    mean_area_px_.assign(n_faces, 0.0);
    pixel_size_.assign(n_faces, 0.0);
    std::vector<std::vector<FaceSight>> sights(n_faces);
    parallel_for(n_faces, [&](std::size_t f) {
        const Triangle& t = surface.triangles[f];
        const Vec3 centroid =
            (surface.vertices[at(t[0])] + surface.vertices[at(t[1])] + surface.vertices[at(t[2])]) / 3.0;
        pixel_size_[f] = std::numeric_limits<double>::infinity();
        for (const PhotoView& view : images.views)
            pixel_size_[f] = std::min(pixel_size_[f], (centroid - view.centre).norm() / view.focal_px);
        sights[f] = look(surface, static_cast<std::int32_t>(f), mean_area_px_[f]);
        for (const FaceSight& sight : sights[f]) slope_[f] = std::max(slope_[f], sight.slope);
    });

    begin_.assign(n_faces + 1, 0);
    for (std::size_t f = 0; f < n_faces; ++f) {
        begin_[f + 1] = begin_[f] + sights[f].size();
        for (const FaceSight& sight : sights[f]) face_views_.push_back(sight.view);
    }
    // A face that is partly hidden asks again for every sample, with the tolerance of its steepest view.
}

std::vector<Visibility::FaceSight> Visibility::look(const SurfaceView& surface, std::int32_t face,
                                                    double& mean_area_px) const {
    const Triangle& t = surface.triangles[at(face)];
    const Vec3 v[3] = {surface.vertices[at(t[0])], surface.vertices[at(t[1])], surface.vertices[at(t[2])]};
    const Vec3 cross = (v[1] - v[0]).cross(v[2] - v[0]);
    const double twice_area = cross.norm();
    std::vector<FaceSight> sights;
    mean_area_px = 0;
    if (twice_area == 0) return sights;
    const Vec3 normal = cross / twice_area;
    const Vec3 centroid = (v[0] + v[1] + v[2]) / 3.0;

    for (std::int32_t i = 0; i < images_->n_views(); ++i) {
        const PhotoView& view = images_->views[at(i)];
        const Vec3 to_camera = (view.centre - centroid).normalized();
        const double cos_theta = normal.dot(to_camera);
        if (cos_theta < options_.min_cos) continue;
        const PhotoLevel& level = view.levels.front();
        Vec3 x[3];
        Vec2 p[3];
        bool in_image = true;
        for (int k = 0; k < 3; ++k) {
            x[k] = level.P * v[k].homogeneous();
            if (x[k].z() <= 0) {
                in_image = false;
                break;
            }
            p[k] = x[k].hnormalized();
            in_image =
                in_image && p[k].x() >= 0 && p[k].y() >= 0 && p[k].x() < level.width - 1 && p[k].y() < level.height - 1;
        }
        if (!in_image) continue;
        const double pixel_over_depth = std::ldexp(1.0, level_) / view.focal_px;
        const double tan_theta = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta)) / cos_theta;
        const auto slope = static_cast<float>(options_.tolerance_px * pixel_over_depth * (1.0 + tan_theta));
        // Corners, edge middles and the centroid: seven probes tell whole, partly and not at all apart.
        const Vec3 probes[7] = {x[0],
                                x[1],
                                x[2],
                                0.5 * (x[0] + x[1]),
                                0.5 * (x[1] + x[2]),
                                0.5 * (x[2] + x[0]),
                                (x[0] + x[1] + x[2]) / 3.0};
        int n_seen = 0;
        for (const Vec3& probe : probes) {
            const Vec2 q = probe.hnormalized() * std::ldexp(1.0, -level_);
            const Image<float>& depth = depth_[at(i)];
            const int x0 = std::min(static_cast<int>(q.x()), depth.width - 2),
                      y0 = std::min(static_cast<int>(q.y()), depth.height - 2);
            const float nearest =
                std::min({depth(x0, y0), depth(x0 + 1, y0), depth(x0, y0 + 1), depth(x0 + 1, y0 + 1)});
            n_seen += probe.z() <= nearest * (1.0 + slope) ? 1 : 0;
        }
        if (n_seen == 0) continue;
        sights.push_back({{i, n_seen == 7}, slope});
        mean_area_px += 0.5 * std::abs(twice_signed_area(p[0], p[1], p[2]));
    }
    if (!sights.empty()) mean_area_px /= static_cast<double>(sights.size());
    return sights;
}

bool Visibility::is_visible(std::int32_t face, std::int32_t view, float x, float y, float z) const {
    const Image<float>& depth = depth_[at(view)];
    x *= scale_;
    y *= scale_;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(depth.width - 1) && y < static_cast<float>(depth.height - 1)))
        return false;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const float nearest = std::min({depth(x0, y0), depth(x0 + 1, y0), depth(x0, y0 + 1), depth(x0 + 1, y0 + 1)});
    return z <= nearest * (1.0F + slope_[at(face)]);
}

}  // namespace anyrate
