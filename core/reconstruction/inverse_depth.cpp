#include "core/reconstruction/inverse_depth.h"

#include <algorithm>
#include <cstring>

#include "core/float4.h"
#include "core/reconstruction/float8.h"
#include "core/vector_clones.h"

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

// What decides which pixels eight triangles cover, a lane each.
struct TriangleLanes {
    Float8 x, y, inverse_depth;  ///< of the first corner, which the functions below are 0 at
    Float8 b_dx, b_dy;           ///< change of the second corner's barycentric coordinate along rows and columns
    Float8 c_dx, c_dy;           ///< of the third corner's
    Float8 depth_dx, depth_dy;   ///< of the inverse depth
    Int8 i0, i1, j0, j1;         ///< the pixels of the bounding box, last ones included
    Int8 covers;                 ///< not 0: faces the camera and has pixels
};

// The corners of eight triangles.
struct CornerLanes {
    Float8 x[3]{}, y[3]{}, inverse_depth[3]{};

    // Up to eight; the lanes left over stay as they are.
    void load(std::span<const ScreenVertex> vertices, std::span<const Triangle> triangles) {
        for (std::size_t lane = 0; lane < triangles.size(); ++lane)
            for (std::size_t k = 0; k < 3; ++k) {
                const ScreenVertex& corner = vertices[at(triangles[lane][k])];
                x[k][lane] = corner.x;
                y[k][lane] = corner.y;
                inverse_depth[k][lane] = corner.inverse_depth;
            }
    }
};

ANYRATE_VECTOR_CLONES
void set_up(const CornerLanes& corners, int width, int height, TriangleLanes& out) {
    // By reference: a function that returned eight lanes would do so differently with AVX2 and without.
    const auto span_of = [](const Float8(&p)[3], Float8& low, Float8& high) {
        low = p[0] < p[1] ? p[0] : p[1];
        low = low < p[2] ? low : p[2];
        high = p[0] < p[1] ? p[1] : p[0];
        high = high < p[2] ? p[2] : high;
    };
    const auto pixels_between = [](const Float8& low, const Float8& high, const Float8& last, Int8& first, Int8& end) {
        Float8 inside = low < 0 ? Float8{} : low;
        inside = inside < last ? inside : last;
        first = __builtin_convertvector(inside, Int8);
        first -= __builtin_convertvector(first, Float8) < inside;
        inside = high < last ? high : last;
        inside = inside < 0 ? Float8{} : inside;
        end = __builtin_convertvector(inside, Int8);
    };
    const Float8 zero{};
    const Float8 last_x = zero + static_cast<float>(width - 1), last_y = zero + static_cast<float>(height - 1);
    const auto& [ax, bx, cx] = corners.x;
    const auto& [ay, by, cy] = corners.y;
    const auto& [az, bz, cz] = corners.inverse_depth;
    const Float8 ab_x = bx - ax, ab_y = by - ay, ac_x = cx - ax, ac_y = cy - ay;
    // Counter-clockwise from outside is clockwise in an image whose y runs down.
    const Float8 area = ab_x * ac_y - ab_y * ac_x;
    Float8 x_min, x_max, y_min, y_max;
    span_of(corners.x, x_min, x_max);
    span_of(corners.y, y_min, y_max);
    pixels_between(x_min, x_max, last_x, out.i0, out.i1);
    pixels_between(y_min, y_max, last_y, out.j0, out.j1);
    out.covers = (az > 0) & (bz > 0) & (cz > 0) & (area < 0) & (x_max >= 0) & (y_max >= 0) & (x_min <= last_x) &
                 (y_min <= last_y) & (out.i0 <= out.i1) & (out.j0 <= out.j1);

    const Float8 per_area = 1.0F / area, db = bz - az, dc = cz - az;
    out.x = ax;
    out.y = ay;
    out.inverse_depth = az;
    out.b_dx = ac_y * per_area;
    out.b_dy = -ac_x * per_area;
    out.c_dx = -ab_y * per_area;
    out.c_dy = ab_x * per_area;
    out.depth_dx = out.b_dx * db + out.c_dx * dc;
    out.depth_dy = out.b_dy * db + out.c_dy * dc;
}

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
void rasterise(const TriangleLanes& triangles, std::size_t lane, Image<float>& inverse_depth) {
    const Linear b(triangles.b_dx[lane], triangles.b_dy[lane]), c(triangles.c_dx[lane], triangles.c_dy[lane]),
        z(triangles.depth_dx[lane], triangles.depth_dy[lane]);
    const float from_x = triangles.x[lane], from_y = triangles.y[lane], from_depth = triangles.inverse_depth[lane];
    for (int j = triangles.j0[lane]; j <= triangles.j1[lane]; ++j) {
        const float y = static_cast<float>(j) - from_y;
        for (int group = triangles.i0[lane]; group <= triangles.i1[lane]; group += lanes) {
            const int i = std::min(group, inverse_depth.width - lanes);
            const float x = static_cast<float>(i) - from_x;
            const Float4 in_b = b.at(x, y), in_c = c.at(x, y), depth = from_depth + z.at(x, y);
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
    CornerLanes corners;
    TriangleLanes group;
    for (std::size_t first = 0; first < triangles.size(); first += n_lanes) {
        const std::size_t n = std::min(n_lanes, triangles.size() - first);
        corners.load(vertices, triangles.subspan(first, n));
        set_up(corners, width, height, group);
        for (std::size_t lane = 0; lane < n; ++lane)
            if (group.covers[lane] != 0) rasterise(group, lane, inverse_depth);
    }
    return inverse_depth;
}

Image<float> render_inverse_depth(const PhotoLevel& level, const SurfaceView& surface) {
    return render_inverse_depth(level.width, level.height, project(level, surface), surface.triangles);
}

}  // namespace anyrate
