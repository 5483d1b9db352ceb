// The energy of the surface as it stands, and what comes next: IS_FIRST the round's first step, for which the terms'
// weights are chosen, else whether the trial is taken (the loop of optimise_surface.cpp).
layout(std430, binding = 6) coherent buffer Terms { float terms[]; };  // N_TERMS a face of the round

// log(1 + x), also where that is next to 0.
float log1p(float x) {
    precise const float sum = 1 + x, rounded = sum - 1;
    return rounded == 0 ? x : log(sum) * (x / rounded);
}

// make_robust() of robust_terms.h, for those terms that a round looks at.
void make_robust(int face) {
    const int at = N_TERMS * face;
    const double n = double(terms[at + 1]);
    if (!(n > 0) || !(credible > 0)) return;
    const double x = double(terms[at]) / (n * credible), slope = 1 / (1 + x);
    terms[at] = float(n * credible * double(log1p(float(x))));
    for (int k = 2; k < 11; ++k) terms[at + k] = float(double(terms[at + k]) * slope);
}

#if IS_FIRST
// credible_distortion() of robust_terms.h
void find_credible() {
    double sum = 0, n_samples = 0;
    for (int i = worker; i < n_faces; i += WORKERS) {
        const double n = double(terms[N_TERMS * i + 1]);
        if (!(n > 0)) continue;
        sum += n * double(log(float(max(noise_psi, double(terms[N_TERMS * i]) / n))));
        n_samples += n;
    }
    sum = total(sum);
    n_samples = total(n_samples);
    if (worker == 0) credible = n_samples > 0 ? outlier * double(exp(float(sum / n_samples))) : 0.0lf;
    meet();
}

// ring_means() of normal_displacement.h, of the umbrellas.
double mean_umbrella(int i) {
    const int first = row_begin(i), last = row_begin(i + 1);
    double sum = field(UMBRELLA, i);
    int n = 1;
    for (int e = first; e < last; ++e) {
        const int j = active_neighbour(e);
        if (j < 0) continue;
        sum += field(UMBRELLA, j);
        ++n;
    }
    return sum / double(n);
}

// What silhouettes and smoothness weigh against phi in this round.
void weigh(double psi) {
    const double noise = psi / noisy_psi;
    const double price = max(psi, min(clean_psi, max(noise_psi, psi * psi / noise_psi)));
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
    if (worker == 0) {
        is_faint = mean < least ? 1 : 0;
        bending = (bending_part + noisy_bending * noise) * max(mean, least);
    }
    for (int i = worker; i < n_active; i += WORKERS) {
        const double curvature = field(REST, i);
        set_field(REST, i, mean_umbrella(i) * (1 - curvature / (curvature + weak_evidence * mean)));
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
#if IS_FIRST
    find_credible();
#endif
    double phi = 0, n = 0;
    for (int i = worker; i < n_faces; i += WORKERS) {
        make_robust(i);
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
