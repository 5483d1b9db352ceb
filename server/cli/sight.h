#pragma once
#include <optional>
#include <vector>

#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// Tells which points of a surface the cameras of a capture see. Meant for the true surface, on which a reconstruction
/// is to be judged only where it was photographed. It works on coarse depth images: a view flatter than about 70
/// degrees to the surface may count as hidden.
class Sight {
public:
    /// @param surface  what hides what, world units
    Sight(const Capture& capture, const Mesh& surface);

    /// Number of views in which no part of the surface is in front of `point`, which is on it or near it.
    int n_views_of(const Vec3& point) const;

private:
    struct DepthView {
        Mat34 P;             ///< to cells of `depth`, cell (x, y) covering [x, x + 1) x [y, y + 1)
        Image<float> depth;  ///< of the surface nearest to the camera anywhere in the cell, world units

        /// The cell a point falls into and its depth there; nothing if it is behind the camera or out of the image.
        struct Hit {
            int x = 0, y = 0;
            float depth = 0;
        };
        std::optional<Hit> project(const Vec3& point) const;
    };
    std::vector<DepthView> views_;
    double tolerance_ = 0;  ///< world units
};

}  // namespace anyrate
