// Each active vertex from where the step starts along its normal, no further than its limit.
layout(local_size_x = 64) in;

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    if (i >= n_active) return;
    const double limit = field(LIMIT, i), along = clamp(field(DISPLACEMENT, i), -limit, limit);
    for (int axis = 0; axis < 3; ++axis)
        positions[3 * active_vertex(i) + axis] = field(START + axis, i) + along * field(START_NORMAL + axis, i);
}
