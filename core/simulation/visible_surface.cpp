#include "core/simulation/visible_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace anyrate {

std::vector<ProjectedTriangle> project_triangles(const Mesh& surface, const Camera& camera) {
    std::vector<Vec3> in_cam(surface.vertices.size());
    std::vector<Vec2> in_image(surface.vertices.size());
    for (std::size_t v = 0; v < in_cam.size(); ++v) {
        in_cam[v] = camera.cam_from_world(surface.vertices[v]);
        assert(in_cam[v].z() > 0);
        in_image[v] = (camera.K * in_cam[v]).hnormalized();
    }
    // The ray through pixel x is d = K^-1 x. It lies on one side of the plane through the camera and two corners a, b
    // as the sign of d . (a x b) = x . K^-T (a x b) says.
    const Mat3 K_inverse_transposed = camera.K.inverse().transpose();
    std::vector<ProjectedTriangle> projected;
    projected.reserve(surface.triangles.size() / 2);
    for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
        const auto& [a, b, c] = surface.triangles[f];
        const double volume = in_cam[a].dot(in_cam[c].cross(in_cam[b]));
        if (!(volume > 0)) continue;  // faces away, or is seen edge-on
        const auto side = [&](int from, int to) { return Vec3(K_inverse_transposed * in_cam[from].cross(in_cam[to])); };
        const auto [x_min, x_max] = std::minmax({in_image[a].x(), in_image[b].x(), in_image[c].x()});
        const auto [y_min, y_max] = std::minmax({in_image[a].y(), in_image[b].y(), in_image[c].y()});
        projected.push_back({.side = {side(c, b), side(a, c), side(b, a)},
                             .inverse_volume = 1 / volume,
                             .x_min = x_min,
                             .x_max = x_max,
                             .y_min = y_min,
                             .y_max = y_max,
                             .triangle = static_cast<std::int32_t>(f)});
    }
    return projected;
}

VisibleBand::VisibleBand(int width, int first_row, int n_rows, int supersampling)
    : width_(width),
      first_row_(first_row),
      n_rows_(n_rows),
      supersampling_(supersampling),
      samples_(static_cast<std::size_t>(width * supersampling) * static_cast<std::size_t>(n_rows * supersampling)) {}

void VisibleBand::draw(const ProjectedTriangle& t, std::int32_t number) {
    // Columns and rows of samples, counted from the image's left and the band's upper edge; one more on every side than
    // the bounds ask for, which are rounded on another path than the weights.
    const auto sample_at = [&](double pixels) { return (pixels + 0.5) * supersampling_ - 0.5; };
    const int n_columns = width_ * supersampling_, n_sample_rows = n_rows_ * supersampling_;
    const int first_column = std::max(static_cast<int>(std::floor(sample_at(t.x_min))), 0);
    const int last_column = std::min(static_cast<int>(std::ceil(sample_at(t.x_max))), n_columns - 1);
    const int first = std::max(static_cast<int>(std::floor(sample_at(t.y_min - first_row_))), 0);
    const int last = std::min(static_cast<int>(std::ceil(sample_at(t.y_max - first_row_))), n_sample_rows - 1);
    for (int row = first; row <= last; ++row) {
        const double y = along(first_row_ * supersampling_ + row);
        for (int column = first_column; column <= last_column; ++column) {
            const Vec3 at(along(column), y, 1);
            const double w0 = t.side[0].dot(at), w1 = t.side[1].dot(at), w2 = t.side[2].dot(at);
            if (w0 < 0 || w1 < 0 || w2 < 0) continue;
            const double inverse_depth = (w0 + w1 + w2) * t.inverse_volume;
            Sample& sample = samples_[static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns) +
                                      static_cast<std::size_t>(column)];
            if (inverse_depth > sample.inverse_depth) sample = {inverse_depth, number};
        }
    }
}

}  // namespace anyrate
