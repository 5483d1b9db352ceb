// Every vertex of the surface as every view sees it: pixel of the depth map and 1 / depth, 0 behind the camera
// (project() of inverse_depth.h). In double precision, as there.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Vertices { double vertices[]; };  // three each
layout(std430, binding = 1) readonly buffer Cameras { double cameras[]; };    // CAMERA_STRIDE a view, P by rows first
layout(std430, binding = 2) writeonly buffer Screen { vec4 screen[]; };       // by views
layout(location = 0) uniform int n_vertices;

double row(int at, dvec3 p) {
    precise double sum = cameras[at] * p.x + cameras[at + 1] * p.y + cameras[at + 2] * p.z + cameras[at + 3];
    return sum;
}

void main() {
    const int v = int(gl_GlobalInvocationID.x), view = int(gl_WorkGroupID.y);
    if (v >= n_vertices) return;
    const dvec3 p = dvec3(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]);
    const double z = row(CAMERA_STRIDE * view + 8, p);
    vec4 seen = vec4(0);
    if (z > 0) {
        precise double inverse_depth = 1.0lf / z;
        precise double x = row(CAMERA_STRIDE * view, p) * inverse_depth, y = row(CAMERA_STRIDE * view + 4, p) * inverse_depth;
        seen = vec4(float(x), float(y), float(inverse_depth), 0);
    }
    screen[view * n_vertices + v] = seen;
}
