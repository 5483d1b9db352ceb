// The displacements that minimise the damped quadratic, by conjugate gradients, all of their iterations in one go
// (NormalDisplacement::solve() of normal_displacement.h).
//
// An entry of the matrix couples an active vertex with a neighbour: second derivative of images and silhouettes; that of
// the vertex's umbrella by the neighbour; that of the neighbour's umbrella by the vertex. A vertex's umbrella changes by
// -1 with the vertex itself.
layout(std430, binding = 7) readonly buffer Entries { double entries[]; };

// The matrix but for the damping times DIRECTION, to APPLIED. @return this worker's part of their product
double apply_to_direction() {
    for (int i = worker; i < n_active; i += WORKERS) {
        const int first = row_begin(i), last = row_begin(i + 1);
        const double own = field(DIRECTION, i);
        double umbrella = -own, sum = (field(HESSIAN, i) + damping * field(DIAGONAL, i)) * own;
        for (int e = first; e < last; ++e) {
            const int j = active_neighbour(e);
            if (j < 0) continue;
            const double p = field(DIRECTION, j);
            umbrella += entries[3 * e + 1] * p;
            sum += entries[3 * e] * p;
        }
        set_field(BENDING, i, umbrella);
        set_field(APPLIED, i, sum);
    }
    meet();
    double product = 0;
    for (int i = worker; i < n_active; i += WORKERS) {
        const int first = row_begin(i), last = row_begin(i + 1);
        double sum = -field(BENDING, i);
        for (int e = first; e < last; ++e) {
            const int j = active_neighbour(e);
            if (j >= 0) sum += entries[3 * e + 2] * field(BENDING, j);
        }
        const double applied = field(APPLIED, i) + 2 * bending * sum;
        set_field(APPLIED, i, applied);
        product += applied * field(DIRECTION, i);
    }
    return product;
}

// Preconditions the residual of a vertex. @return its part of the product of the two
double precondition(int i, double residual) {
    const double diagonal = field(DIAGONAL, i);
    const double z = diagonal > 0 ? residual / (diagonal * (1 + damping)) : 0.0lf;
    set_field(PRECONDITIONED, i, z);
    return residual * z;
}

void main() {
    double rz = 0;
    for (int i = worker; i < n_active; i += WORKERS) {
        const int first = row_begin(i), last = row_begin(i + 1);
        double gradient = field(GRADIENT, i) - 2 * bending * field(BENT, i), diagonal = field(HESSIAN, i) + 2 * bending;
        for (int e = first; e < last; ++e) {
            const int j = active_neighbour(e);
            if (j < 0) continue;
            const double transpose = entries[3 * e + 2];
            gradient += 2 * bending * field(BENT, j) * transpose;
            diagonal += 2 * bending * transpose * transpose;
        }
        set_field(DIAGONAL, i, diagonal);
        set_field(DISPLACEMENT, i, 0.0lf);
        set_field(RESIDUAL, i, -gradient);
        rz += precondition(i, -gradient);
        set_field(DIRECTION, i, field(PRECONDITIONED, i));
    }
    rz = total(rz);
    const double target = double(CG_TOLERANCE) * double(CG_TOLERANCE) * rz;
    for (int k = 0; k < MAX_CG_ITERATIONS && rz > target; ++k) {
        meet();
        const double pAp = total(apply_to_direction());
        if (!(pAp > 0)) break;
        const double alpha = rz / pAp;
        double next = 0;
        for (int i = worker; i < n_active; i += WORKERS) {
            set_field(DISPLACEMENT, i, field(DISPLACEMENT, i) + alpha * field(DIRECTION, i));
            const double residual = field(RESIDUAL, i) - alpha * field(APPLIED, i);
            set_field(RESIDUAL, i, residual);
            next += precondition(i, residual);
        }
        next = total(next);
        const double beta = next / rz;
        rz = next;
        for (int i = worker; i < n_active; i += WORKERS)
            set_field(DIRECTION, i, field(PRECONDITIONED, i) + beta * field(DIRECTION, i));
    }
}
