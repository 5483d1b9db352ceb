// What the shaders share.

// A face of the current surface.
struct Face {
    int n_views;   // that see it
    int steps;     // per edge of its lattice of samples
    float slope;   // tolerance of its depth, a part of depth
    int unused;
    double area_px;  // mean over its views, pixels of level 0
};

// A triangle of a batch.
struct Query {
    double corners[9];
    float directions[9];  // along which its corners move
    int face;
};

// A triangle of a batch in one of the views that see it (TriangleView of sample_lanes.h).
struct Pair {
    float corner_x[3], corner_y[3], corner_z[3];  // homogeneous pixel from the origin, and depth
    float motion_x[3], motion_y[3], motion_z[3];
    int x, y;             // of the origin
    float width, height;  // from the origin to where the last bilinear patch starts
    int sight;            // 2 view + (whole ? 1 : 0)
};

bool is_on_map(vec3 p, vec2 size) { return p.z > 0 && p.x >= 0 && p.y >= 0 && p.x < size.x && p.y < size.y; }

// Largest 1 / depth of the four pixels around a point, which must have them, each with its neighbours as
// widen_far_contours() of inverse_depth.h takes them.
// @param size      of the view's depth map, pixels
// @param far_part  see there
float nearest_around(usampler2DArray inverse_depth, int view, vec2 p, ivec2 size, float far_part) {
    const ivec2 first = ivec2(int(p.x), int(p.y));
    uint nearest = 0, around = 0;
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) {
            const ivec2 pixel = clamp(first + ivec2(x, y), ivec2(0), size - 1);
            const uint depth = texelFetch(inverse_depth, ivec3(pixel, view), 0).r;
            around = max(around, depth);
            if (x == clamp(x, 0, 1) && y == clamp(y, 0, 1)) nearest = max(nearest, depth);
        }
    precise float hidden_behind = far_part * uintBitsToFloat(around);
    return max(uintBitsToFloat(nearest), hidden_behind);
}
