// The energy around the step's start as a quadratic function of the displacements: a row an active vertex
// (NormalDisplacement of normal_displacement.h).
layout(local_size_x = 64) in;
layout(std430, binding = 6) readonly buffer Terms { float terms[]; };          // N_TERMS a face of the round
layout(std430, binding = 7) writeonly buffer Entries { double entries[]; };    // three a neighbour, see solve.comp

// Entry (a, b) of a triangle's Hessian in the order of TriangleTerms.
int hessian_slot(int a, int b) {
    return a == b ? a : a + b == 1 ? 3 : a + b == 3 ? 4 : 5;
}

double hessian(int slot, int a, int b) { return double(terms[N_TERMS * slot + 5 + hessian_slot(a, b)]); }

int corner_of(ivec3 t, int v) { return t.x == v ? 0 : t.y == v ? 1 : t.z == v ? 2 : -1; }

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    if (i >= n_active) return;
    const int v = active_vertex(i);
    const dvec3 along = normal(v), start = position(v);
    for (int axis = 0; axis < 3; ++axis) {
        set_field(START + axis, i, start[axis]);
        set_field(START_NORMAL + axis, i, along[axis]);
    }
    set_field(BENT, i, field(UMBRELLA, i) - field(REST, i));

    const int first_face = ring_begin(v), last_face = ring_begin(v + 1);
    double gradient = 0, own = 0;
    for (int k = first_face; k < last_face; ++k) {
        const int f = ring_face(k), slot = items[slots_at + f];
        if (slot < 0) continue;
        const int corner = corner_of(triangle(f), v);
        gradient += double(terms[N_TERMS * slot + 2 + corner]);
        own += hessian(slot, corner, corner);
    }
    set_field(GRADIENT, i, gradient + field(WEIGHT, i) * field(CONTOUR + 1, i));
    set_field(HESSIAN, i, own + field(WEIGHT, i) * field(CONTOUR + 2, i));

    const int first = row_begin(i), last = row_begin(i + 1);
    for (int e = first; e < last; ++e) {
        double shared_with = 0, umbrella = 0, transpose = 0;
        const int w = neighbour(e);
        if (active_neighbour(e) >= 0) {
            for (int k = first_face; k < last_face; ++k) {
                const int f = ring_face(k), slot = items[slots_at + f];
                const ivec3 t = triangle(f);
                const int other = corner_of(t, w);
                if (slot >= 0 && other >= 0) shared_with += hessian(slot, corner_of(t, v), other);
            }
            const double cosine = dot(along, normal(w));
            umbrella = cosine / double(last - first);
            transpose = cosine / double(valence_of_neighbour(e));
        }
        entries[3 * e] = shared_with;
        entries[3 * e + 1] = umbrella;
        entries[3 * e + 2] = transpose;
    }
}
