#pragma once
#include <optional>
#include <span>
#include <vector>

#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// What the samples of one triangle say: phi(T) = sum of omega_p F(p) over them (Nghiem et al., Eq. 8).
struct TriangleDistortion {
    double phi = 0.0;        ///< squared 8-bit colour units
    double n_samples = 0.0;  ///< sum of omega_p over the samples with evidence (seen by two views or more)
};

/// Distortion G(v) of every vertex: its one-ring's mean photo-consistency per sample.
/// Source: Nghiem et al., Eq. 9, from the triangle distortions of Eq. 8. N_s(v) counts samples by their weight omega,
/// as phi does, so that G does not depend on how samples are shared along edges.
/// @param triangles  n_faces entries, from the same surface
/// @return n_vertices values, squared colour units; a ring without samples gives no evidence: nullopt
std::vector<std::optional<double>> vertex_distortion(const OneRings& rings, int n_vertices,
                                                     std::span<const TriangleDistortion> triangles);

/// Distortion Psi of the whole surface, average per sample. Source: Nghiem et al., Eq. 10.
/// @return squared colour units; 0 for a surface without evidence
double surface_distortion(std::span<const TriangleDistortion> triangles);

}  // namespace anyrate
