#include "core/reconstruction/view_shifts.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>

#include "core/parallel.h"
#include "core/reconstruction/inverse_depth.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int n_iterations = 4;
constexpr double least_cos = 0.5;     // of the angle under which a view sees a point
constexpr double hidden_px = 2.0;     // behind the nearest surface, in pixels of the depth map
constexpr float usual_residual = 12;  // of 255: larger ones count for less
constexpr double least_slope = 1;     // of colour, per pixel: an image with less has little to hold on to
constexpr int fewest_others = 2;      // views that a view is compared with at a point
constexpr std::size_t fewest_points = 100;

// A vertex where a view sees it.
struct Sighting {
    std::int32_t vertex;
    Vec2 pixel;  // of the level
};

std::vector<Sighting> sightings(const PhotoView& view, int level, const SurfaceView& surface,
                                const std::vector<Vec3>& normals) {
    const PhotoLevel& image = view.levels[at(level)];
    const PhotoLevel depth_level = without_colours(image);
    const Image<float> inverse_depth = render_inverse_depth(depth_level, surface);
    const double px = std::ldexp(1.0, level + 1) / view.focal_px;
    std::vector<Sighting> seen;
    for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
        const Vec3& p = surface.vertices[v];
        if (normals[v].dot((view.centre - p).normalized()) < least_cos) continue;
        const Vec3 x = image.P * p.homogeneous();
        if (!(x.z() > 0)) continue;
        const Vec2 pixel = x.hnormalized();
        const int u = static_cast<int>((pixel.x() + 0.5) / 2), w = static_cast<int>((pixel.y() + 0.5) / 2);
        if (!inverse_depth.contains(u, w) || x.z() * inverse_depth(u, w) > 1 + hidden_px * px) continue;
        seen.push_back({static_cast<std::int32_t>(v), pixel});
    }
    return seen;
}

}  // namespace

std::vector<Vec2> estimate_shifts(const PhotoImages& images, const SurfaceView& surface, int level) {
    const std::vector<Vec3> normals = vertex_normals(surface, OneRings(surface));
    const std::size_t n_views = images.views.size(), n_vertices = surface.vertices.size();
    std::vector<std::vector<Sighting>> seen(n_views);
    parallel_for(
        n_views, [&](std::size_t i) { seen[i] = sightings(images.views[i], level, surface, normals); }, 1);

    std::vector<Vec2> shifts(n_views, Vec2::Zero());  // pixels of the level
    std::vector<std::vector<ColourSample>> colours(n_views);
    std::vector<std::vector<char>> known(n_views);
    std::vector<Eigen::Vector4f> sums(n_vertices);  // of the colours, and their number
    for (int iteration = 0; iteration < n_iterations; ++iteration) {
        parallel_for(
            n_views,
            [&](std::size_t i) {
                colours[i].resize(seen[i].size());
                known[i].resize(seen[i].size());
                const PhotoLevel& image = images.views[i].levels[at(level)];
                for (std::size_t k = 0; k < seen[i].size(); ++k) {
                    const Vec2 x = seen[i][k].pixel + shifts[i];
                    known[i][k] = sample_colour(image, x.x(), x.y(), colours[i][k]);
                }
            },
            1);
        std::fill(sums.begin(), sums.end(), Eigen::Vector4f::Zero());
        for (std::size_t i = 0; i < n_views; ++i)
            for (std::size_t k = 0; k < seen[i].size(); ++k)
                if (known[i][k]) {
                    const float* c = colours[i][k].c;
                    sums[at(seen[i][k].vertex)] += Eigen::Vector4f(c[0], c[1], c[2], 1);
                }
        parallel_for(
            n_views,
            [&](std::size_t i) {
                Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
                Vec2 b = Vec2::Zero();
                std::size_t n_points = 0;
                for (std::size_t k = 0; k < seen[i].size(); ++k) {
                    const Eigen::Vector4f& sum = sums[at(seen[i][k].vertex)];
                    if (!known[i][k] || sum[3] < 1 + fewest_others) continue;
                    const ColourSample& s = colours[i][k];
                    ++n_points;
                    for (int c = 0; c < 3; ++c) {
                        const double residual = s.c[c] - (sum[c] - s.c[c]) / (sum[3] - 1);
                        const double relative = residual / usual_residual;
                        const double weight = 1 / (1 + relative * relative);
                        const Vec2 g(s.dx[c], s.dy[c]);
                        A += weight * g * g.transpose();
                        b -= weight * residual * g;
                    }
                }
                if (n_points < fewest_points) return;
                A += Eigen::Matrix2d::Identity() * (3.0 * static_cast<double>(n_points) * least_slope * least_slope);
                const Vec2 step = A.ldlt().solve(b);
                shifts[i] += step.cwiseMax(-1).cwiseMin(1);
            },
            1);
    }
    for (Vec2& shift : shifts) shift *= std::ldexp(1.0, level);
    return shifts;
}

void shift_views(PhotoImages& images, std::span<const Vec2> shifts) {
    for (std::size_t i = 0; i < shifts.size(); ++i) {
        double scale = 1;
        for (PhotoLevel& level : images.views[i].levels) {
            level.P.topRows<2>() += scale * shifts[i] * level.P.row(2);
            scale /= 2;
        }
    }
}

}  // namespace anyrate
