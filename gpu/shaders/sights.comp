// For each face asked for the views that see it, ascending, with what follows from them (Visibility of visibility.h):
// whether they see it whole, the tolerance of its depth, its mean area, its samples' steps (Nghiem et al., Eq. 7).
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Vertices { double vertices[]; };
layout(std430, binding = 1) readonly buffer Triangles { int triangles[]; };
layout(std430, binding = 2) readonly buffer Cameras { double cameras[]; };
layout(std430, binding = 3) readonly buffer Screen { vec4 screen[]; };
layout(std430, binding = 4) readonly buffer Sizes { int sizes[]; };  // see DepthMaps
layout(std430, binding = 5) readonly buffer Asked { int asked[]; };
layout(std430, binding = 6) writeonly buffer Sights { int sights[]; };  // n_views a face: 2 view + (whole ? 1 : 0)
layout(std430, binding = 7) writeonly buffer Faces { Face faces[]; };
layout(binding = 0) uniform usampler2DArray inverse_depth;
layout(location = 0) uniform int n_asked;
layout(location = 1) uniform int n_vertices;
layout(location = 2) uniform int n_views;
layout(location = 3) uniform float area_scale;  // half a pixel of the depth map, in pixels of level 0
layout(location = 4) uniform double min_cos;
layout(location = 5) uniform double samples_per_area;  // of a pixel of level 0, twice: 2 C of Eq. 7

dvec3 vertex(int v) { return dvec3(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]); }

int is_seen(int view, vec3 probe, float slope) {
    precise float nearer = probe.z * (1.0 + slope);
    const ivec2 size = ivec2(sizes[2 * view], sizes[2 * view + 1]);
    const float far_part = intBitsToFloat(sizes[2 * n_views + view]);
    return nearer >= nearest_around(inverse_depth, view, probe.xy, size, far_part) ? 1 : 0;
}

void main() {
    const int item = int(gl_GlobalInvocationID.x);
    if (item >= n_asked) return;
    const int f = asked[item];
    const ivec3 t = ivec3(triangles[3 * f], triangles[3 * f + 1], triangles[3 * f + 2]);
    const dvec3 corner = vertex(t.x);
    const dvec3 centre_of_face = (corner + vertex(t.y) + vertex(t.z)) / 3.0lf;
    dvec3 normal = cross(vertex(t.y) - corner, vertex(t.z) - corner);
    const double norm = sqrt(dot(normal, normal));
    if (norm > 0) normal /= norm;

    int n = 0;
    float steepest = 0;
    double area_px = 0;
    for (int view = 0; view < n_views; ++view) {
        const int camera = 16 * view;
        const dvec3 to_camera = dvec3(cameras[camera + 12], cameras[camera + 13], cameras[camera + 14]) - centre_of_face;
        const double along = dot(normal, to_camera);
        if (!(along > 0)) continue;
        const double cos_theta = along / sqrt(dot(to_camera, to_camera));
        if (cos_theta < min_cos) continue;
        const double tan_theta = sqrt(max(0.0lf, 1.0lf - cos_theta * cos_theta)) / cos_theta;
        const float slope = float(cameras[camera + 15] * (1.0lf + tan_theta));

        const vec3 a = screen[view * n_vertices + t.x].xyz, b = screen[view * n_vertices + t.y].xyz,
                   c = screen[view * n_vertices + t.z].xyz;
        const vec2 size = vec2(sizes[2 * view] - 1, sizes[2 * view + 1] - 1);
        if (!(is_on_map(a, size) && is_on_map(b, size) && is_on_map(c, size))) continue;
        precise vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
        precise vec3 centre = (1.0 / 3.0) * (a + b + c);
        const int n_seen = is_seen(view, a, slope) + is_seen(view, ab, slope) + is_seen(view, b, slope) +
                           is_seen(view, bc, slope) + is_seen(view, c, slope) + is_seen(view, ca, slope) +
                           is_seen(view, centre, slope);
        if (n_seen == 0) continue;
        precise float area = area_scale * abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        sights[f * n_views + n] = 2 * view + (n_seen == 7 ? 1 : 0);
        ++n;
        steepest = max(steepest, slope);
        area_px += double(area);
    }
    if (n > 0) area_px /= double(n);
    faces[f] = Face(n, clamp(int(floor(sqrt(samples_per_area * area_px) + 0.5lf)), 1, MAX_STEPS), steepest, 0, area_px);
}
