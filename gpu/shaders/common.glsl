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

// Largest 1 / depth of the four pixels around a point, which must have them.
float nearest_around(usampler2DArray inverse_depth, int view, vec2 p) {
    const ivec3 at = ivec3(int(p.x), int(p.y), view);
    const uint top = max(texelFetch(inverse_depth, at, 0).r, texelFetch(inverse_depth, at + ivec3(1, 0, 0), 0).r);
    const uint bottom =
        max(texelFetch(inverse_depth, at + ivec3(0, 1, 0), 0).r, texelFetch(inverse_depth, at + ivec3(1, 1, 0), 0).r);
    return uintBitsToFloat(max(top, bottom));
}
