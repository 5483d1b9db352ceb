// Outward unit normals of all vertices, area-weighted over the one-ring (vertex_normals() of surface_view.h).
layout(local_size_x = 64) in;

void main() {
    const int v = int(gl_GlobalInvocationID.x);
    if (v >= n_vertices) return;
    const int first = ring_begin(v), last = ring_begin(v + 1);
    dvec3 sum = dvec3(0);
    for (int k = first; k < last; ++k) {
        const ivec3 t = triangle(ring_face(k));
        const dvec3 a = position(t.x);
        sum += cross(position(t.y) - a, position(t.z) - a);
    }
    const double norm = sqrt(dot(sum, sum));
    if (norm > 0) sum /= norm;
    for (int axis = 0; axis < 3; ++axis) normals[3 * v + axis] = norm > 0 ? sum[axis] : 0.0lf;
}
