#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/reconstruction/float8.h"

namespace anyrate {

/// Eight samples of a triangle's lattice (sampling.h), a lane each. What is left over in the last eight of a lattice
/// weighs nothing.
struct SampleLanes {
    Float8 b[3];          ///< barycentric coordinates
    Float8 weight;        ///< omega of Eq. 8; 0 at a corner, whose weight is 1/valence
    Float8 is_corner[3];  ///< 1 or 0
    Float8 middle[3];     ///< hat functions of the middles of the edges
};

/// The lattice with M steps per edge, 1 .. max_lattice_steps, by eights.
std::span<const SampleLanes> lattice_lanes(int M);

/// One view of a triangle. Pixels are relative to a corner of the triangle's box in the view, so that single precision
/// resolves a thousandth of a pixel in any image.
struct TriangleView {
    std::int32_t view = 0;
    bool whole = false;                    ///< no part is hidden
    std::int32_t x = 0, y = 0;             ///< of the origin, pixels of the level
    float width = 0, height = 0;           ///< from the origin to where the last bilinear patch starts
    const std::uint8_t* pixels = nullptr;  ///< RGBA (photo_images.h), at the origin
    std::int32_t row = 0;                  ///< bytes
    /// Homogeneous pixel and depth of the corners.
    float corner_x[3], corner_y[3], corner_z[3];
    /// How they move with the scalars u of the corners; only if derivatives are asked for.
    float motion_x[3], motion_y[3], motion_z[3];
};

/// Eight samples in one view. Lanes that the view does not see hold numbers, but of no meaning.
struct LanesInView {
    Float8 seen;                     ///< 1 or 0
    Float8 x, y;                     ///< pixels from the view's origin
    Float8 inverse_z;                ///< 1 / depth
    Int8 offset;                     ///< of the bilinear patch from the view's pixels, bytes; -1 outside the image
    Float8 colour[3], dx[3], dy[3];  ///< red, green, blue, 0..255, and their derivatives by the pixel position
};

/// Sums over a triangle's samples, still by lane; add them up at the end.
struct TermLanes {
    Float8 phi{}, n_samples{};
    Float8 gradient[3]{}, hessian_own[3]{}, hessian_next[3]{}, middle_gradient[3]{}, middle_hessian[3]{};
};

/// Projects the samples into every view and finds their colours. A view sees a sample if the four pixels around it are
/// the object's alone; what hides it is the caller's to tell.
/// @param samples  one per view
void look_at_lanes(const SampleLanes& lanes, std::span<const TriangleView> views, std::span<LanesInView> samples);

/// Adds phi and the number of samples. Source: Nghiem et al., Eqs. 5 and 8, in the two-pass form of
/// photo_consistency(); a sample counts where two views see it.
/// @param weight  omega of each sample
void add_distortion(const Float8& weight, std::span<const LanesInView> samples, TermLanes& sums);

/// Adds everything, the derivative of Eq. 5 along the motion of the corners included: dF/du = 2/(K-1) sum (C_i - mean
/// C) dC_i/du; the Gauss-Newton Hessian 2/(K-1) sum (dC_i/du - mean)^2 takes one direction per sample, the barycentric
/// mean of the three.
/// @param samples  their derivatives by the pixel are replaced by those along that direction, in dx
void add_terms(const SampleLanes& lanes, const Float8& weight, std::span<const TriangleView> views,
               std::span<LanesInView> samples, TermLanes& sums);

/// The sum over the lanes.
double sum_of_lanes(const Float8& lanes);

}  // namespace anyrate
