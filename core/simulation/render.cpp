#include "core/simulation/render.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "core/simulation/hash.h"
#include "core/simulation/visible_surface.h"

namespace anyrate {
namespace {

constexpr int band_rows =
    16;  // pixel rows rendered at a time: enough bands for all threads, small enough for the cache

/// Linear light behind the object: dark, a little cold.
const Vec3 background(0.016, 0.019, 0.025);

/// For every band of rows the triangles that reach into it, in their order.
std::vector<std::vector<std::int32_t>> sort_into_bands(const std::vector<ProjectedTriangle>& triangles, int height) {
    const int n_bands = (height + band_rows - 1) / band_rows;
    std::vector<std::vector<std::int32_t>> bands(static_cast<std::size_t>(n_bands));
    const auto band_of = [](double y) { return static_cast<int>(std::floor(y / band_rows)); };
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        // A pixel more on both sides: a row of pixels covers half a pixel above and below its centres.
        const int first = std::max(band_of(triangles[i].y_min - 1), 0);
        const int last = std::min(band_of(triangles[i].y_max + 1), n_bands - 1);
        for (int b = first; b <= last; ++b) bands[static_cast<std::size_t>(b)].push_back(static_cast<std::int32_t>(i));
    }
    return bands;
}

/// Light from the point where the ray through a pixel position meets the triangle.
Vec3 shade(const Model& model, const ProjectedTriangle& projected, const Vec3& position) {
    const Triangle& corners = model.surface.triangles[static_cast<std::size_t>(projected.triangle)];
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double weight = projected.side[i].dot(position);
        point += weight * model.surface.vertices[corners[i]];
        normal += weight * model.normals[corners[i]];
        sum += weight;
    }
    return model.appearance(point / sum, normal.normalized());
}

/// The light of a pixel's samples and how many of its samples hit the surface.
struct PixelLight {
    Vec3 sum = Vec3::Zero();
    int n_hits = 0;
};

PixelLight gather(const Model& model, const std::vector<ProjectedTriangle>& triangles, const VisibleBand& band, int x,
                  int y, int supersampling) {
    PixelLight light;
    for (int j = 0; j < supersampling; ++j) {
        for (int i = 0; i < supersampling; ++i) {
            const std::int32_t nearest = band.nearest(x, y, i, j);
            if (nearest < 0) {
                light.sum += background;
            } else {
                light.sum += shade(model, triangles[static_cast<std::size_t>(nearest)], band.position(x, y, i, j));
                ++light.n_hits;
            }
        }
    }
    return light;
}

/// 255 x^(1/2.2), before rounding.
double encode_gamma(double linear) { return 255 * std::pow(std::clamp(linear, 0.0, 1.0), 1 / 2.2); }

std::uint8_t to_byte(double level) { return static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L)); }

/// What the sensor makes of a pixel: levels before rounding, the noise drawn from the pixel's number.
Rgb8 expose(const std::array<double, 3>& levels, std::uint64_t pixel, const RenderOptions& options) {
    std::array<std::uint8_t, 3> bytes;
    for (std::size_t c = 0; c < 3; ++c) {
        bytes[c] = to_byte(levels[c] + options.noise * near_normal(hash(options.seed, 3 * pixel + c)));
    }
    return {bytes[0], bytes[1], bytes[2]};
}

}  // namespace

std::uint8_t to_level(double linear) { return to_byte(encode_gamma(linear)); }

double studio_light(const Vec3& normal) {
    // A sky above, a warm window on one side, a reflector on the other. The window's light wraps around the shape
    // (the cosine is raised and squared), so that nothing is lost in black.
    static const Vec3 window = Vec3(0.62, 0.48, 0.62).normalized(), reflector = Vec3(-0.70, -0.62, 0.10).normalized();
    const auto wrapped = [&](const Vec3& light) {
        const double raised = 0.5 + 0.5 * normal.dot(light);
        return raised * raised;
    };
    return 0.30 + 0.18 * (0.5 + 0.5 * normal.z()) + 0.36 * wrapped(window) + 0.16 * wrapped(reflector);
}

View render_view(const Model& model, const Camera& camera, std::string name, const RenderOptions& options) {
    View view{.name = std::move(name),
              .camera = camera,
              .image = ColourImage(camera.width, camera.height),
              .mask = MaskImage(camera.width, camera.height)};
    const std::vector<ProjectedTriangle> triangles = project_triangles(model.surface, camera);
    const auto bands = sort_into_bands(triangles, camera.height);
    const int n_samples = options.supersampling * options.supersampling;
    const std::array<double, 3> background_levels{encode_gamma(background.x()), encode_gamma(background.y()),
                                                  encode_gamma(background.z())};
    const auto render_band = [&](std::size_t b) {
        const int first_row = static_cast<int>(b) * band_rows;
        const int end_row = std::min(first_row + band_rows, camera.height);
        VisibleBand band(camera.width, first_row, end_row - first_row, options.supersampling);
        for (const std::int32_t i : bands[b]) band.draw(triangles[static_cast<std::size_t>(i)], i);
        for (int y = first_row; y < end_row; ++y) {
            for (int x = 0; x < camera.width; ++x) {
                const PixelLight light = gather(model, triangles, band, x, y, options.supersampling);
                std::array<double, 3> levels = background_levels;
                for (int c = 0; c < 3 && light.n_hits > 0; ++c) levels[c] = encode_gamma(light.sum[c] / n_samples);
                view.image(x, y) = expose(levels, static_cast<std::uint64_t>(y) * camera.width + x, options);
                view.mask(x, y) = 2 * light.n_hits >= n_samples ? 255 : 0;
            }
        }
    };
    parallel_for(bands.size(), render_band, 1);
    return view;
}

}  // namespace anyrate
