// What the silhouettes say of each active vertex (Silhouettes::terms() of silhouette_term.h), and its umbrella.
layout(local_size_x = 64) in;
layout(std430, binding = 6) readonly buffer Cameras { double cameras[]; };  // 20 a view
layout(binding = 0) uniform usampler2DArray distances;  // four to a texel, the left-most in the lowest byte
layout(binding = 1) uniform usampler2DArray coverage;   // 1 / depth as bits, 0 where there is no surface
layout(location = 0) uniform int n_views;

const double distances_per_px = 8.0lf;  // silhouette_distance()

// Of a view's numbers: P by rows, then
const int CENTRE = 12, COVERAGE_SCALE = 15, SIZE = 16, COVERAGE_SIZE = 18;

double row(int at, dvec3 p) { return cameras[at] * p.x + cameras[at + 1] * p.y + cameras[at + 2] * p.z; }

double distance_at(int view, int x, int y) {
    const int four = int(texelFetch(distances, ivec3(x / 4, y, view), 0).r);
    return double(bitfieldExtract(four, 8 * (x % 4), 8));
}

bool is_on_rim(int v, dvec3 centre) {
    const int first = ring_begin(v), last = ring_begin(v + 1);
    bool front = false, back = false;
    for (int k = first; k < last; ++k) {
        const ivec3 t = triangle(ring_face(k));
        const dvec3 a = position(t.x);
        if (dot(cross(position(t.y) - a, position(t.z) - a), centre - a) > 0)
            front = true;
        else
            back = true;
    }
    return front && back;
}

bool is_covered(int view, dvec2 pixel) {
    const int camera = 20 * view;
    const dvec2 on_map = floor((pixel + 0.5lf) * cameras[camera + COVERAGE_SCALE]);
    if (!(on_map.x >= 0 && on_map.y >= 0 && on_map.x < cameras[camera + COVERAGE_SIZE] &&
          on_map.y < cameras[camera + COVERAGE_SIZE + 1]))
        return false;
    return texelFetch(coverage, ivec3(int(on_map.x), int(on_map.y), view), 0).r != 0u;
}

// Energy, derivative and second derivative in a view.
dvec3 term_in(int view, int v, dvec3 point, dvec3 along) {
    const int camera = 20 * view;
    const double z = row(camera + 8, point) + cameras[camera + 11];
    if (!(z > 0)) return dvec3(0);
    const dvec2 p = dvec2(row(camera, point) + cameras[camera + 3], row(camera + 4, point) + cameras[camera + 7]) / z;
    if (!(p.x >= 0 && p.y >= 0 && p.x < cameras[camera + SIZE] - 1 && p.y < cameras[camera + SIZE + 1] - 1))
        return dvec3(0);
    const int x = int(p.x), y = int(p.y);
    const double fu = p.x - double(x), fv = p.y - double(y);
    const double a = distance_at(view, x, y), b = distance_at(view, x + 1, y), c = distance_at(view, x, y + 1),
                 d = distance_at(view, x + 1, y + 1);
    const double signed_px = ((1 - fv) * (a + fu * (b - a)) + fv * (c + fu * (d - c))) / distances_per_px;
    if (signed_px > reach_px) return dvec3(0);
    const double dx = ((1 - fv) * (b - a) + fv * (d - c)) / distances_per_px,
                 dy = ((1 - fu) * (c - a) + fu * (d - b)) / distances_per_px;
    const double q_z = row(camera + 8, along);
    const dvec2 motion = dvec2(row(camera, along) - p.x * q_z, row(camera + 4, along) - p.y * q_z) / z;
    if (signed_px >= 0) {
        const dvec3 centre = dvec3(cameras[camera + CENTRE], cameras[camera + CENTRE + 1], cameras[camera + CENTRE + 2]);
        if (motion == dvec2(0) || !is_on_rim(v, centre)) return dvec3(0);
        // With surface just beyond it, the contour lies within the object's outline.
        if (is_covered(view, p + beyond_px * (motion / sqrt(dot(motion, motion))))) return dvec3(0);
    }
    const double slope = dx * motion.x + dy * motion.y;
    return dvec3(signed_px * signed_px, 2 * signed_px * slope, 2 * slope * slope);
}

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    if (i >= n_active) return;
    const int v = active_vertex(i);
    const dvec3 point = position(v), along = normal(v);
    dvec3 sum = dvec3(0);
    for (int view = 0; view < n_views; ++view) sum += term_in(view, v, point, along);
    for (int k = 0; k < 3; ++k) set_field(CONTOUR + k, i, sum[k]);

    dvec3 mean = dvec3(0);
    const int first = row_begin(i), last = row_begin(i + 1);
    for (int e = first; e < last; ++e) mean += position(neighbour(e));
    set_field(UMBRELLA, i, dot(mean / double(last - first) - point, along));
}
