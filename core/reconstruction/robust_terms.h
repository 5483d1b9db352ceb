#pragma once
#include <span>

#include "core/reconstruction/photo_backend.h"

namespace anyrate {

/// The distortion of a sample that the images can still be believed at: `outlier` times the usual one, which is the
/// geometric mean over all samples, each with its face's mean distortion or, if that is more, `noise`.
/// @param noise    squared colour units, above 0
/// @return squared colour units; infinity if there are no samples
double credible_distortion(std::span<const TriangleTerms> terms, double noise, double outlier);

/// n T log(1 + G / T) of a face with n samples, more than 0, of mean distortion G; T is the credible distortion.
/// @return squared colour units, as phi
double robust_phi(const TriangleDistortion& face, double credible);

/// What faces say beyond the credible counts by its logarithm only: phi becomes robust_phi(), and the derivatives
/// follow, the Hessians without the part that is negative. Else a few faces whose samples come into sight, of something
/// else or a highlight, with residuals of some thousands outweigh whatever all others gain by a step. Source: Cauchy's
/// function, as in Black and Rangarajan 1996, "On the Unification of Line Processes, Outlier Rejection, and Robust
/// Statistics with Applications in Early Vision".
void make_robust(std::span<TriangleTerms> terms, double credible);

}  // namespace anyrate
