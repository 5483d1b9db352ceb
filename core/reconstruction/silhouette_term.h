#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/capture/capture.h"
#include "core/capture/image.h"
#include "core/reconstruction/photo_images.h"
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

/// Pulls contours to the image contours: a vertex on the rim of the surface as a view sees it, with nothing of the
/// surface just beyond it, belongs on the mask's border, and no vertex belongs outside any mask.
/// Source: Gargallo, Prados, Sturm 2007 and Delaunoy, Prados 2011 derive the pull from the visibility's derivative;
/// here it is the squared distance to the border, which a Gauss-Newton step can use.
class Silhouettes {
public:
    explicit Silhouettes(const Capture& capture);

    /// Moves what every camera shows by its shift, pixels of the photographs; one entry a view.
    void shift_views(std::span<const Vec2> shifts);

    /// Moves the borders of all masks outwards from where the capture has them, or inwards if negative, pixels of the
    /// photographs. @param px  at most most_growth_px either way
    void grow_masks(double px);
    double growth_px() const { return growth_px_; }
    static constexpr double most_growth_px = 4.0;

    /// Renders what the surface covers in every view, once for many terms().
    void look(const SurfaceView& surface);

    /// Terms of the listed vertices, by the coverage of the last look().
    /// @param normals   one unit normal per vertex of the surface
    /// @param reach_px  rim vertices further inside a mask do not feel its border, pixels of the photographs; at most
    /// 15 less most_growth_px
    std::vector<SilhouetteTerm> terms(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                                      std::span<const std::int32_t> vertices, double reach_px) const;

    /// How far inside the borders the surface's contours lie: the signed distances of all rim vertices within reach
    /// that have nothing of the surface just beyond them, by the coverage of the last look(); view by view, pixels of
    /// the photographs. Parameters as for terms().
    std::vector<double> contour_distances(const SurfaceView& surface, const OneRings& rings,
                                          std::span<const Vec3> normals, double reach_px) const;

    struct View {
        Mat34 P;
        Vec3 centre;
        /// To the borders as they were moved: silhouette_distance(), or that and a number. Never changed, but replaced.
        std::shared_ptr<const Image<std::int8_t>> distance;
        PhotoLevel coverage_level;  ///< its camera at half the resolution or less; no colours
        double coverage_scale = 1;  ///< of a pixel of the photograph at that level
        Image<float> coverage;      ///< inverse depth of the last look(), 0 where there is no surface
    };
    /// For who computes the terms elsewhere than on the CPU.
    std::span<const View> views() const { return views_; }
    static constexpr double beyond_px = 2.0;  ///< how far outside a rim vertex the surface has to end

private:
    struct Sight;
    static std::optional<Sight> sight_of(const View& view, const Vec3& point, const Vec3& normal, double reach_px);
    static bool ends_beyond(const View& view, const Sight& sight);
    template <class IsOnRim>
    static SilhouetteTerm term_in(const View& view, const Vec3& point, const Vec3& normal, double reach_px,
                                  const IsOnRim& is_on_rim);

    std::vector<View> views_;
    std::vector<std::shared_ptr<const Image<std::int8_t>>> given_;  ///< the distances by the capture's own masks
    double growth_px_ = 0;
};

}  // namespace anyrate
