#include "core/reconstruction/inverse_depth.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>

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

    void set(std::size_t lane, std::size_t k, const ScreenVertex& corner) {
        x[k][lane] = corner.x;
        y[k][lane] = corner.y;
        inverse_depth[k][lane] = corner.inverse_depth;
    }
};

// What an image is rendered of: the pixels of a box, those of the whole image to the bit.
struct Frame {
    int width, height;  ///< of the whole image
    PixelBox box;
};

ANYRATE_VECTOR_CLONES
void set_up(const CornerLanes& corners, const Frame& frame, TriangleLanes& out) {
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
    const Float8 last_x = zero + static_cast<float>(frame.width - 1);
    const Float8 last_y = zero + static_cast<float>(frame.height - 1);
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
    // Whole groups are left out, so that those that stay are the same as in the whole image.
    const PixelBox& box = frame.box;
    const Int8 skipped = box.x0 - out.i0;
    out.i0 += (skipped > 0 ? skipped : Int8{}) & ~(lanes - 1);
    out.i1 = out.i1 < box.x1 - 1 ? out.i1 : Int8{} + (box.x1 - 1);
    out.j0 = out.j0 > box.y0 ? out.j0 : Int8{} + box.y0;
    out.j1 = out.j1 < box.y1 - 1 ? out.j1 : Int8{} + (box.y1 - 1);
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

template <int lane>
Float4 splat(const Float4& v) {
    return __builtin_shufflevector(v, v, lane, lane, lane, lane);
}

// The largest of the image and the triangle. Pixels are visited in groups of four along the columns of the bounding
// box; what a group has beyond the triangle keeps its value. Three functions that are linear on the screen are 0 at the
// first corner: two barycentric coordinates, which tell what is inside, and how inverse depth changes.
void rasterise(const TriangleLanes& triangles, std::size_t lane, int width, InverseDepthPart& part) {
    const Float4 dx{triangles.b_dx[lane], triangles.c_dx[lane], triangles.depth_dx[lane], 0};
    const Float4 dy{triangles.b_dy[lane], triangles.c_dy[lane], triangles.depth_dy[lane], 0};
    constexpr Float4 steps{0, 1, 2, 3};
    const Float4 along_b = splat<0>(dx) * steps, along_c = splat<1>(dx) * steps, along_z = splat<2>(dx) * steps;
    const float from_x = triangles.x[lane], from_y = triangles.y[lane], from_depth = triangles.inverse_depth[lane];
    const int j0 = triangles.j0[lane], j1 = triangles.j1[lane], i1 = triangles.i1[lane];
    for (int group = triangles.i0[lane]; group <= i1; group += lanes) {
        const int i = std::min(group, width - lanes);
        const Float4 at_x = dx * (static_cast<float>(i) - from_x);
        float* pixels = &part.pixels(i - part.x, j0 - part.y);
        for (int j = j0; j <= j1; ++j, pixels += part.pixels.width) {
            const Float4 first = at_x + dy * (static_cast<float>(j) - from_y);
            const Float4 b = along_b + splat<0>(first), c = along_c + splat<1>(first);
            const Float4 depth = from_depth + (along_z + splat<2>(first)), before = load(pixels);
            const Float4 inside = ((b >= 0) & (c >= 0) & (b + c <= 1)) ? depth : Float4{};
            store(inside > before ? inside : before, pixels);
        }
    }
}

ScreenVertex project(const PhotoLevel& level, const Vec3& vertex) {
    const Vec3 x = level.P * vertex.homogeneous();
    if (!(x.z() > 0)) return {};
    const double inverse_depth = 1.0 / x.z();
    return {static_cast<float>(x.x() * inverse_depth), static_cast<float>(x.y() * inverse_depth),
            static_cast<float>(inverse_depth)};
}

bool looks_at_camera(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0;  // see set_up()
}

}  // namespace

std::vector<ScreenVertex> project(const PhotoLevel& level, const SurfaceView& surface) {
    std::vector<ScreenVertex> projected(surface.vertices.size());
    for (std::size_t v = 0; v < projected.size(); ++v) projected[v] = project(level, surface.vertices[v]);
    return projected;
}

std::vector<ScreenVertex> project(const PhotoLevel& level, const SurfaceView& surface,
                                  std::span<const std::int32_t> some) {
    std::vector<ScreenVertex> projected(surface.vertices.size());
    for (const std::int32_t v : some) projected[at(v)] = project(level, surface.vertices[at(v)]);
    return projected;
}

PixelBox pixels_around(std::span<const ScreenVertex> vertices, int width, int height) {
    // Two boxes at once: each comparison waits for the one before.
    float low_x[2], low_y[2], high_x[2], high_y[2];
    for (int k = 0; k < 2; ++k) {
        low_x[k] = low_y[k] = std::numeric_limits<float>::infinity();
        high_x[k] = high_y[k] = -low_x[k];
    }
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const ScreenVertex& p = vertices[v];
        const std::size_t k = v % 2;
        low_x[k] = std::min(low_x[k], p.x);
        low_y[k] = std::min(low_y[k], p.y);
        high_x[k] = std::max(high_x[k], p.x);
        high_y[k] = std::max(high_y[k], p.y);
    }
    const auto pixel = [](float x, int last) {
        return static_cast<int>(std::clamp(x, 0.0F, static_cast<float>(last)));
    };
    const float left = std::min(low_x[0], low_x[1]) - 1, top = std::min(low_y[0], low_y[1]) - 1;
    const float right = std::max(high_x[0], high_x[1]) + 2, bottom = std::max(high_y[0], high_y[1]) + 2;
    return {pixel(left, width), pixel(top, height), pixel(right, width), pixel(bottom, height)};
}

ANYRATE_VECTOR_CLONES
void widen_far_contours(InverseDepthPart& part, float far_part) {
    Image<float>& depth = part.pixels;
    if (depth.pixels.empty()) return;
    const auto width = static_cast<std::size_t>(depth.width), height = static_cast<std::size_t>(depth.height);
    const auto larger = [](float a, float b) { return a < b ? b : a; };
    // The largest of every pixel and the two beside it; of a row above the image those of its first row.
    std::vector<float> beside(width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const float* const row = depth.pixels.data() + y * width;
        float* const out = beside.data() + y * width;
        for (std::size_t x = 1; x + 1 < width; ++x) out[x] = larger(larger(row[x - 1], row[x]), row[x + 1]);
        out[0] = larger(row[0], row[std::min<std::size_t>(1, width - 1)]);
        out[width - 1] = larger(row[width - 1], row[width - std::min<std::size_t>(2, width)]);
    }
    for (std::size_t y = 0; y < height; ++y) {
        float* const row = depth.pixels.data() + y * width;
        const float* const here = beside.data() + y * width;
        const float* const above = beside.data() + (y > 0 ? y - 1 : 0) * width;
        const float* const below = beside.data() + std::min(y + 1, height - 1) * width;
        for (std::size_t x = 0; x < width; ++x)
            row[x] = larger(row[x], far_part * larger(larger(above[x], here[x]), below[x]));
    }
}

ANYRATE_VECTOR_CLONES
void take_largest_of_four(Image<float>& depth) {
    const auto width = static_cast<std::size_t>(depth.width), height = static_cast<std::size_t>(depth.height);
    const auto larger = [](float a, float b) { return a < b ? b : a; };
    for (std::size_t y = 0; y + 1 < height; ++y) {
        float* const row = depth.pixels.data() + y * width;
        const float* const below = row + width;
        for (std::size_t x = 0; x + 1 < width; ++x)
            row[x] = larger(larger(row[x], row[x + 1]), larger(below[x], below[x + 1]));
    }
}

InverseDepthPart render_inverse_depth_in(const PixelBox& box, int width, int height,
                                         std::span<const ScreenVertex> vertices, std::span<const Triangle> triangles) {
    assert(!box.is_empty() && box.x0 >= 0 && box.y0 >= 0 && box.x1 <= width && box.y1 <= height);
    // Groups at the box's sides reach beyond it.
    const int left = std::max(0, box.x0 - (lanes - 1)), right = std::min(width, box.x1 + (lanes - 1));
    InverseDepthPart part{left, box.y0, Image<float>(right - left, box.height(), 0.0F)};
    draw_inverse_depth(box, width, height, vertices, triangles, part);
    return part;
}

void draw_inverse_depth(const PixelBox& box, int width, int height, std::span<const ScreenVertex> vertices,
                        std::span<const Triangle> triangles, InverseDepthPart& part) {
    if (width < lanes) return;  // no image of an object is so narrow
    const Frame frame{width, height, box};
    CornerLanes corners;
    std::size_t n = 0;
    const auto draw = [&] {
        TriangleLanes group;
        set_up(corners, frame, group);
        for (std::size_t lane = 0; lane < n; ++lane)
            if (group.covers[lane] != 0) rasterise(group, lane, width, part);
        n = 0;
    };
    for (const Triangle& t : triangles) {
        const ScreenVertex &a = vertices[at(t[0])], &b = vertices[at(t[1])], &c = vertices[at(t[2])];
        corners.set(n, 0, a);
        corners.set(n, 1, b);
        corners.set(n, 2, c);
        n += looks_at_camera(a, b, c) ? 1 : 0;  // without a branch, which would be a coin's toss
        if (n == n_lanes) draw();
    }
    draw();
}

std::vector<Triangle> triangles_at(const PixelBox& box, std::span<const ScreenVertex> vertices,
                                   std::span<const Triangle> triangles) {
    const auto x0 = static_cast<float>(box.x0), x1 = static_cast<float>(box.x1 - 1);
    const auto y0 = static_cast<float>(box.y0), y1 = static_cast<float>(box.y1 - 1);
    std::vector<std::uint8_t> outside(vertices.size());  // on which sides a vertex lies, a bit each
    for (std::size_t v = 0; v < outside.size(); ++v) {
        const ScreenVertex& p = vertices[v];
        outside[v] = static_cast<std::uint8_t>((p.x < x0) | (p.x > x1) << 1 | (p.y < y0) << 2 | (p.y > y1) << 3);
    }
    std::vector<Triangle> near;
    for (const Triangle& t : triangles)
        if ((outside[at(t[0])] & outside[at(t[1])] & outside[at(t[2])]) == 0) near.push_back(t);
    return near;
}

Image<float> render_inverse_depth(int width, int height, std::span<const ScreenVertex> vertices,
                                  std::span<const Triangle> triangles) {
    if (width <= 0 || height <= 0) return Image<float>(width, height);
    return render_inverse_depth_in({0, 0, width, height}, width, height, vertices, triangles).pixels;
}

Image<float> render_inverse_depth(const PhotoLevel& level, const SurfaceView& surface) {
    return render_inverse_depth(level.width, level.height, project(level, surface), surface.triangles);
}

}  // namespace anyrate
