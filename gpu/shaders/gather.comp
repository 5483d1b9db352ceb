// The faces of a round as a batch for see.comp: where their corners stand, and the normals there.
layout(local_size_x = 64) in;
layout(std430, binding = 6) writeonly buffer Queries { Query queries[]; };

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    if (i >= n_faces) return;
    const int f = items[faces_at + i];
    queries[i].face = f;
    for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            queries[i].corners[3 * k + axis] = positions[3 * triangles[3 * f + k] + axis];
            queries[i].directions[3 * k + axis] = float(normals[3 * triangles[3 * f + k] + axis]);
        }
}
