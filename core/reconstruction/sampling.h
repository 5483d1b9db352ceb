#pragma once
#include <span>
#include <vector>

#include "core/types.h"

namespace anyrate {

/// A sample of a triangle: p = b[0] v1 + b[1] v2 + b[2] v3, and what it counts in Eq. 8.
struct LatticeSample {
    double b[3];
    double weight;      ///< omega: 1 inside, 1/2 on an edge; at a corner 0 here, it is 1/valence there
    int corner;         ///< 0, 1, 2 if the sample is that corner, else -1
    float b_single[3];  ///< b in single precision
    float middle[3];    ///< hat functions of the middles of the edges 01, 12, 20, as a 1-to-4 split makes them
};

/// The regular lattice of Nghiem et al., Eq. 6: p = v1 (1 - m) + v2 m (1 - n) + v3 m n with m = i/M and n = j/i, so row
/// i of M has i + 1 samples, (M + 1)(M + 2) / 2 in all.
/// @param M steps per edge, 1 .. max_lattice_steps
std::span<const LatticeSample> lattice(int M);
inline constexpr int max_lattice_steps = 64;

/// Steps per edge from the triangle's projected areas, Nghiem et al., Eq. 7: M = max(1, sqrt(2 f)), f = C mean A_i, so
/// that a triangle gets about C samples per image pixel that shows it. Rounded to the nearest integer, at most
/// max_lattice_steps.
/// @param mean_area_px mean of A_i over the views that see the triangle, pixels; 0 where none does
/// @param C samples per pixel
int lattice_steps(double mean_area_px, double C);

/// How a surface's samples are shared out among its triangles.
enum class Sampling {
    adaptive,  ///< by projected area, Eq. 7
    uniform,   ///< the same number in every triangle: what the paper compares Eq. 7 with (Fig. 7)
};

/// Steps per edge of every triangle. Uniform sampling takes the one number of steps that gives the triangles which are
/// seen (of an area above 0) as nearly as possible as many lattice points together as Eq. 7 does.
/// @param mean_areas_px  per triangle, as for the function above
std::vector<int> lattice_steps(std::span<const double> mean_areas_px, double C, Sampling sampling);

}  // namespace anyrate
