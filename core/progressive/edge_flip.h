#pragma once
// When an edge gives way to the other diagonal of its two faces, as far as the four positions tell: proto/FORMAT.md,
// "Flip". Triangles of a surface with curvature want to be long where it bends least, so an edge that lies along a
// ridge must not be turned across it because the angles would be nicer (Simpson 1994, "Anisotropic mesh
// transformations").
#include "core/progressive/curvature_metric.h"
#include "core/progressive/lattice_arithmetic.h"
#include "core/progressive/refinement_rules.h"

namespace anyrate {

/// Two triangles p q m and q p s that share the edge from p to q; grid units.
struct EdgeQuad {
    LatticeVector p, q, m, s;
};

/// Whether edge p q is to become m s. Strict: a tie keeps the edge.
/// @param metric  of the face that is being split, if the rule wants one and there is one
inline bool wants_flip(const EdgeQuad& quad, FlipRule rule, const CurvatureMetric* metric = nullptr) {
    constexpr double coplanar_cosine = 0.96875, needle_cosine = 0.8125;  // 14 and 36 degrees
    constexpr double needle_cotangents = 2;                              // opposite angles of 270 degrees together
    const auto& [p, q, m, s] = quad;
    const double dot_m = dot(p - m, q - m), dot_s = dot(p - s, q - s);
    if (!metric && dot_m >= 0 && dot_s >= 0) return false;  // no angle above 90 degrees: the sum cannot be negative

    const LatticeVector normal_m = cross(q - p, m - p), normal_s = cross(p - q, s - q);
    const double sine_m = length(normal_m), sine_s = length(normal_s);
    const double cotangents = dot_m * sine_s + dot_s * sine_m, sines = sine_m * sine_s;  // cot m + cot s, times sines
    if (rule == FlipRule::delaunay) {
        if (!(cotangents < 0)) return false;
    } else {
        const double cosine = dot(normal_m, normal_s);  // times sines
        const bool are_needles = cotangents < -needle_cotangents * sines;
        if (!(cosine >= (are_needles ? needle_cosine : coplanar_cosine) * sines)) return false;
        const double sum = are_needles || !metric ? cotangents
                                                  : metric->inner_product(p - m, q - m) * sine_s +
                                                        metric->inner_product(p - s, q - s) * sine_m;
        if (!(sum < 0)) return false;
    }

    const LatticeVector old_normals = normal_m + normal_s;
    return dot(cross(p - m, s - m), old_normals) > 0 && dot(cross(q - s, m - s), old_normals) > 0;
}

}  // namespace anyrate
