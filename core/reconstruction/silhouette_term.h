#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/capture/capture.h"
#include "core/capture/image.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// Signed distance to the mask's border in eighths of a pixel, positive inside, clamped to 127; the border runs
/// half-way between the last pixel inside and the first outside.
Image<std::int8_t> silhouette_distance(const MaskImage& mask);

/// What the silhouettes say of one vertex as a function of its displacement along its normal: a sum of squared
/// distances, in pixels of the photographs, and its derivatives.
struct SilhouetteTerm {
    double energy = 0, gradient = 0, hessian = 0;
};

/// Pulls contours to the image contours: a vertex on the rim of the surface as a view sees it belongs on the mask's
/// border if it is within `reach_px` of it, and no vertex belongs outside any mask. Source: Gargallo, Prados, Sturm
/// 2007 and Delaunoy, Prados 2011 derive the pull from the visibility's derivative; here it is the squared distance to
/// the border, which a Gauss-Newton step can use.
class Silhouettes {
public:
    explicit Silhouettes(const Capture& capture);

    /// Terms of the listed vertices. @param normals one unit normal per vertex of the surface
    std::vector<SilhouetteTerm> terms(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                                      std::span<const std::int32_t> vertices, double reach_px) const;

private:
    struct View {
        Mat34 P;
        Vec3 centre;
        Image<std::int8_t> distance;
    };
    static SilhouetteTerm term_in(const View& view, const Vec3& point, const Vec3& normal, bool on_rim,
                                  double reach_px);

    std::vector<View> views_;
};

}  // namespace anyrate
