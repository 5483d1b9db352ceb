#include "core/reconstruction/robust_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace anyrate {

double credible_distortion(std::span<const TriangleTerms> terms, double noise, double outlier) {
    double sum = 0, n_samples = 0;
    for (const TriangleTerms& t : terms) {
        const double n = t.distortion.n_samples;
        if (n <= 0) continue;
        sum += n * std::log(std::max(noise, t.distortion.phi / n));
        n_samples += n;
    }
    return n_samples > 0 ? outlier * std::exp(sum / n_samples) : std::numeric_limits<double>::infinity();
}

double robust_phi(const TriangleDistortion& face, double credible) {
    return face.n_samples * credible * std::log1p(face.phi / (face.n_samples * credible));
}

void make_robust(std::span<TriangleTerms> terms, double credible) {
    if (std::isinf(credible)) return;
    for (TriangleTerms& t : terms) {
        const double n = t.distortion.n_samples;
        if (n <= 0) continue;
        const double slope = 1 / (1 + t.distortion.phi / (n * credible));
        t.distortion.phi = robust_phi(t.distortion, credible);
        for (auto* derivatives : {&t.gradient, &t.middle_gradient, &t.middle_hessian})
            for (double& d : *derivatives) d *= slope;
        for (double& h : t.hessian) h *= slope;
    }
}

}  // namespace anyrate
