#include "core/reconstruction/inverse_depth.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/reconstruction/float4.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int lanes = 4;  // neighbouring pixels of a row

Float4 load(const float* from) {
    Float4 v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
void store(const Float4& v, float* to) { std::memcpy(to, &v, sizeof v); }

// A function that is linear on the screen and 0 at the origin: its values at the pixels of a group, and how they change
// from group to group and from row to row.
struct Linear {
    float dx, dy;
    Float4 within;  ///< a group, from its first pixel

    Linear(float along_x, float along_y) : dx(along_x), dy(along_y), within{0, along_x, 2 * along_x, 3 * along_x} {}
    Float4 at(float x, float y) const { return within + (dx * x + dy * y); }
};

// The largest of the image and the triangle. Pixels are visited in groups of four along the rows of the bounding box;
// what a group has beyond the triangle keeps its value.
void rasterise(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, Image<float>& inverse_depth) {
    if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) return;
    const float bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    // Counter-clockwise from outside is clockwise in an image whose y runs down.
    const float area = bx * cy - by * cx;
    if (!(area < 0)) return;
    const auto [x_min, x_max] = std::minmax({a.x, b.x, c.x});
    const auto [y_min, y_max] = std::minmax({a.y, b.y, c.y});
    const int w = inverse_depth.width, h = inverse_depth.height;
    if (!(x_max >= 0 && y_max >= 0 && x_min <= static_cast<float>(w - 1) && y_min <= static_cast<float>(h - 1))) return;
    const int i0 = static_cast<int>(std::ceil(std::max(x_min, 0.0F)));
    const int i1 = static_cast<int>(std::min(x_max, static_cast<float>(w - 1)));
    const int j0 = static_cast<int>(std::ceil(std::max(y_min, 0.0F)));
    const int j1 = static_cast<int>(std::min(y_max, static_cast<float>(h - 1)));
    if (i0 > i1) return;

    // Barycentric coordinates of b and c and the inverse depth, from a.
    const float per_area = 1 / area;
    const Linear u(cy * per_area, -cx * per_area), v(-by * per_area, bx * per_area);
    const float db = b.inverse_depth - a.inverse_depth, dc = c.inverse_depth - a.inverse_depth;
    const Linear z(u.dx * db + v.dx * dc, u.dy * db + v.dy * dc);
    for (int j = j0; j <= j1; ++j) {
        const float y = static_cast<float>(j) - a.y;
        for (int group = i0; group <= i1; group += lanes) {
            const int i = std::min(group, w - lanes);
            const float x = static_cast<float>(i) - a.x;
            const Float4 in_b = u.at(x, y), in_c = v.at(x, y), depth = a.inverse_depth + z.at(x, y);
            float* pixels = &inverse_depth(i, j);
            const Float4 before = load(pixels);
            const auto is_nearer = (in_b >= 0) & (in_c >= 0) & (in_b + in_c <= 1) & (depth > before);
            store(is_nearer ? depth : before, pixels);
        }
    }
}

}  // namespace

std::vector<ScreenVertex> project(const PhotoLevel& level, const SurfaceView& surface) {
    std::vector<ScreenVertex> projected(surface.vertices.size());
    for (std::size_t v = 0; v < projected.size(); ++v) {
        const Vec3 x = level.P * surface.vertices[v].homogeneous();
        if (!(x.z() > 0)) continue;
        const double inverse_depth = 1.0 / x.z();
        projected[v] = {static_cast<float>(x.x() * inverse_depth), static_cast<float>(x.y() * inverse_depth),
                        static_cast<float>(inverse_depth)};
    }
    return projected;
}

Image<float> render_inverse_depth(int width, int height, std::span<const ScreenVertex> vertices,
                                  std::span<const Triangle> triangles) {
    Image<float> inverse_depth(width, height, 0.0F);
    if (width < lanes) return inverse_depth;  // no image of an object is so narrow
    for (const Triangle& t : triangles)
        rasterise(vertices[at(t[0])], vertices[at(t[1])], vertices[at(t[2])], inverse_depth);
    return inverse_depth;
}

Image<float> render_inverse_depth(const PhotoLevel& level, const SurfaceView& surface) {
    return render_inverse_depth(level.width, level.height, project(level, surface), surface.triangles);
}

}  // namespace anyrate
