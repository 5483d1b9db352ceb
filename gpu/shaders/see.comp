// Each triangle of a batch in each view that sees it, in double precision and from there on in single precision from an
// origin close by, as CpuBackend::see() takes it.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Queries { Query queries[]; };
layout(std430, binding = 1) readonly buffer Faces { Face faces[]; };
layout(std430, binding = 2) readonly buffer Sights { int sights[]; };
layout(std430, binding = 3) readonly buffer Cameras { double cameras[]; };  // of the level
layout(std430, binding = 4) readonly buffer Sizes { int sizes[]; };         // of its images
layout(std430, binding = 5) writeonly buffer Pairs { Pair pairs[]; };       // n_views a triangle
layout(location = 0) uniform int first_query;
layout(location = 1) uniform int n_queries;
layout(location = 2) uniform int n_views;

double row(int at, dvec3 p) { return cameras[at] * p.x + cameras[at + 1] * p.y + cameras[at + 2] * p.z; }

int origin(double lowest, int size) { return int(clamp(floor(lowest - 0.01lf), 0.0lf, double(size - 1))); }

void main() {
    const int item = int(gl_GlobalInvocationID.x);
    if (item >= n_queries * n_views) return;
    const int q = first_query + item / n_views, k = item % n_views;
    const int face = queries[q].face;
    if (k >= faces[face].n_views) return;
    const int sight = sights[face * n_views + k], view = sight / 2, camera = 16 * view;
    dvec3 p[3];
    dvec2 lowest;
    for (int i = 0; i < 3; ++i) {
        const dvec3 corner = dvec3(queries[q].corners[3 * i], queries[q].corners[3 * i + 1], queries[q].corners[3 * i + 2]);
        p[i] = dvec3(row(camera, corner) + cameras[camera + 3], row(camera + 4, corner) + cameras[camera + 7],
                     row(camera + 8, corner) + cameras[camera + 11]);
        const dvec2 pixel = p[i].xy / p[i].z;
        lowest = i == 0 ? pixel : min(lowest, pixel);
    }
    const int width = sizes[2 * view], height = sizes[2 * view + 1];
    Pair pair;
    pair.sight = sight;
    pair.x = origin(lowest.x, width);
    pair.y = origin(lowest.y, height);
    pair.width = float(width - 1 - pair.x);
    pair.height = float(height - 1 - pair.y);
    for (int i = 0; i < 3; ++i) {
        pair.corner_x[i] = float(p[i].x - double(pair.x) * p[i].z);
        pair.corner_y[i] = float(p[i].y - double(pair.y) * p[i].z);
        pair.corner_z[i] = float(p[i].z);
#if WITH_DERIVATIVES
        const dvec3 along =
            dvec3(queries[q].directions[3 * i], queries[q].directions[3 * i + 1], queries[q].directions[3 * i + 2]);
        const dvec3 m = dvec3(row(camera, along), row(camera + 4, along), row(camera + 8, along));
        pair.motion_x[i] = float(m.x - double(pair.x) * m.z);
        pair.motion_y[i] = float(m.y - double(pair.y) * m.z);
        pair.motion_z[i] = float(m.z);
#else
        pair.motion_x[i] = 0;
        pair.motion_y[i] = 0;
        pair.motion_z[i] = 0;
#endif
    }
    pairs[item] = pair;
}
