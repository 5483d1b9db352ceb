#pragma once
#include <vector>

#include "core/capture/capture.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// Tells which points of a surface the cameras of a capture see, by coarse depth images of that surface: of the true
/// surface, on which a reconstruction is to be judged only where it was photographed.
class Sight {
public:
    /// @param surface  what hides what; closed, world units
    Sight(const Capture& capture, const Mesh& surface);

    /// Number of views in which no part of the surface is in front of `point`, which is on it or near it.
    int n_views_of(const Vec3& point) const;

private:
    struct DepthView {
        Mat34 P;  ///< to pixels of `depth`, convention of camera.h
        Image<float> depth;
    };
    std::vector<DepthView> views_;
    double tolerance_ = 0;  ///< world units
};

}  // namespace anyrate
