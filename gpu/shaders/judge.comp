// The energy of the surface as it stands, and what comes next: IS_FIRST the round's first step, for which the terms'
// weights are chosen, else whether the trial is taken (the loop of optimise_surface.cpp).
layout(std430, binding = 6) readonly buffer Terms { float terms[]; };  // N_TERMS a face of the round

#if IS_FIRST
// What silhouettes and smoothness weigh against phi in this round.
void weigh(double psi) {
    const double noise = psi / noisy_psi;
    const double price = max(psi, min(clean_psi, max(noise_psi, psi * psi / faint_psi)));
    const double contour = silhouette * (1 + 2 * noise) * (first_samples > 0 ? price : clean_psi);
    double sum = 0, n_with_evidence = 0;
    for (int i = worker; i < n_active; i += WORKERS) {
        set_field(WEIGHT, i, field(WEIGHT, i) * contour);
        const int v = active_vertex(i);
        const int first = ring_begin(v), last = ring_begin(v + 1);
        double curvature = 0;
        for (int k = first; k < last; ++k) {
            const int f = ring_face(k), slot = items[slots_at + f];
            if (slot < 0) continue;
            const ivec3 t = triangle(f);
            curvature += double(terms[N_TERMS * slot + 5 + (t.x == v ? 0 : t.y == v ? 1 : 2)]);
        }
        set_field(REST, i, curvature);
        sum += curvature;
        n_with_evidence += curvature > 0 ? 1 : 0;
    }
    sum = total(sum);
    n_with_evidence = total(n_with_evidence);
    const double mean = n_with_evidence > 0 ? sum / n_with_evidence : 1.0lf;
    const double least = least_curvature * first_samples / n_active;
    if (worker == 0) bending = (bending_part + noisy_bending * noise) * max(mean, least);
    for (int i = worker; i < n_active; i += WORKERS) {
        const double curvature = field(REST, i);
        set_field(REST, i, field(UMBRELLA, i) * (1 - curvature / (curvature + weak_evidence * mean)));
    }
    meet();
}
#endif

void open(bool trial_gates, bool assembles, bool last_gates) {
    for (int k = 0; k < n_gates; ++k)
        gates[k].is_open = (k == 0 ? trial_gates && assembles : k < n_trial_gates ? trial_gates : last_gates) ? 1u : 0u;
}

void open_step() {
    const bool is_last = n_taken + 1 == n_steps;  // which is taken on trust
    open(!is_last, true, is_last);
    if (is_last) falls = 1;
}

void main() {
    double phi = 0, n = 0;
    for (int i = worker; i < n_faces; i += WORKERS) {
        phi += double(terms[N_TERMS * i]);
        n += double(terms[N_TERMS * i + 1]);
    }
    phi = total(phi);
    n = total(n);
#if IS_FIRST
    if (worker == 0) first_samples = n;
    meet();
    weigh(n > 0 ? phi / n : 0.0lf);
#endif
    double regularity = 0;
    for (int i = worker; i < n_active; i += WORKERS) {
        const double off = field(UMBRELLA, i) - field(REST, i);
        regularity += field(WEIGHT, i) * field(CONTOUR, i) + bending * off * off;
    }
    const double now = (n > 0 ? phi / n * first_samples : 0.0lf) + total(regularity);
#if IS_FIRST
    if (worker == 0) {
        energy = now;
        open_step();
    }
#else
    const bool is_taken = now < energy, is_given_up = !is_taken && n_refused + 1 == most_trials;
    meet();
    if (is_given_up)
        for (int i = worker; i < n_active; i += WORKERS)
            for (int axis = 0; axis < 3; ++axis)
                positions[3 * active_vertex(i) + axis] = field(START + axis, i);
    if (worker != 0) return;
    if (is_taken) {
        const bool goes_on = now < energy * (1 - converged);
        damping = max(damping / less_damping, least_damping);
        energy = now;
        n_refused = 0;
        if (goes_on) {
            falls = 1;
            ++n_taken;
            open_step();
        } else {
            open(false, false, false);
        }
    } else {
        damping *= more_damping;
        ++n_refused;
        open(!is_given_up, false, false);
    }
#endif
}
