// The largest 1 / depth at every pixel of every view's depth map, operation by operation as rasterise() of
// inverse_depth.cpp takes it, so that CPU and GPU hide the same samples. Positive floats are ordered as their bits are.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Triangles { int triangles[]; };  // three each
layout(std430, binding = 1) readonly buffer Screen { vec4 screen[]; };
layout(std430, binding = 2) readonly buffer Sizes { int sizes[]; };  // of the depth maps: width, height
layout(r32ui, binding = 0) uniform coherent uimage2DArray inverse_depth;
layout(location = 0) uniform int n_faces;
layout(location = 1) uniform int n_vertices;

const int lanes = 4;  // the pixels that the CPU visits at a time: the sums start at the first of them

void main() {
    const int f = int(gl_GlobalInvocationID.x), view = int(gl_WorkGroupID.y);
    if (f >= n_faces) return;
    const int first = view * n_vertices;
    const vec3 a = screen[first + triangles[3 * f]].xyz, b = screen[first + triangles[3 * f + 1]].xyz,
               c = screen[first + triangles[3 * f + 2]].xyz;
    if (!(a.z > 0 && b.z > 0 && c.z > 0)) return;
    precise float bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    precise float area = bx * cy - by * cx;
    if (!(area < 0)) return;
    const float x_min = min(min(a.x, b.x), c.x), x_max = max(max(a.x, b.x), c.x);
    const float y_min = min(min(a.y, b.y), c.y), y_max = max(max(a.y, b.y), c.y);
    const int w = sizes[2 * view], h = sizes[2 * view + 1];
    if (!(x_max >= 0 && y_max >= 0 && x_min <= float(w - 1) && y_min <= float(h - 1)) || w < lanes) return;
    const int i0 = int(ceil(max(x_min, 0.0))), i1 = int(min(x_max, float(w - 1)));
    const int j0 = int(ceil(max(y_min, 0.0))), j1 = int(min(y_max, float(h - 1)));

    // A quotient of floats taken in double precision is rounded as the CPU's is, on every GPU.
    precise float per_area = float(1.0lf / double(area));
    precise float u_dx = cy * per_area, u_dy = -cx * per_area, v_dx = -by * per_area, v_dy = bx * per_area;
    precise float db = b.z - a.z, dc = c.z - a.z;
    precise float z_dx = u_dx * db + v_dx * dc, z_dy = u_dy * db + v_dy * dc;
    for (int j = j0; j <= j1; ++j) {
        precise float y = float(j) - a.y;
        for (int group = i0; group <= i1; group += lanes) {
            const int i = min(group, w - lanes);
            precise float x = float(i) - a.x;
            precise float u = u_dx * x + u_dy * y, v = v_dx * x + v_dy * y, z = z_dx * x + z_dy * y;
            for (int lane = 0; lane < lanes; ++lane) {
                precise float in_b = float(lane) * u_dx + u, in_c = float(lane) * v_dx + v;
                precise float both = in_b + in_c;
                if (!(in_b >= 0 && in_c >= 0 && both <= 1)) continue;
                precise float depth = float(lane) * z_dx + z;
                depth = a.z + depth;
                if (!(depth > 0)) continue;
                const ivec3 pixel = ivec3(i + lane, j, view);
                if (imageLoad(inverse_depth, pixel).r < floatBitsToUint(depth))
                    imageAtomicMax(inverse_depth, pixel, floatBitsToUint(depth));
            }
        }
    }
}
