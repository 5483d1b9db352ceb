#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "gpu/egl_context.h"
#include "gpu/gpu_surface.h"
#include "gpu/photo_textures.h"

namespace anyrate {

/// A triangle of a batch as shaders/common.glsl has it.
struct DeviceQuery {
    double corners[9];
    float directions[9];
    std::int32_t face;
};
static_assert(sizeof(DeviceQuery) == 112);

/// Starts a program for so many items, now or when the device itself decides on it.
using Dispatch = std::function<void(const GlProgram& program, std::size_t n_items)>;

/// What is looked at: the current surface in the photographs of a level.
struct TermsScene {
    const GpuSurface& surface;
    const PhotoTextures& photographs;
    const GlBuffer &cameras, &sizes;  ///< of the level's images
    std::size_t n_views = 0;
    int level = 0;
};

/// Photo-consistency of batches of triangles that are on the device already.
class DeviceTerms {
public:
    /// @param with_derivatives  n_terms numbers a triangle, else n_distortion_terms. @throws DeviceError
    DeviceTerms(const GraphicsDevice& device, bool with_derivatives, DeviceWork& work);

    /// Has the numbers of n queries put into results(), in their order. @throws DeviceError
    void run(const GlBuffer& queries, std::size_t n, const TermsScene& scene, const Dispatch& dispatch);

    const GlBuffer& results() const { return results_; }
    std::size_t n_results() const { return n_results_; }

    static constexpr std::size_t n_terms = 17;            ///< of TriangleTerms
    static constexpr std::size_t n_distortion_terms = 2;  ///< of TriangleDistortion

private:
    void run_part(const GlBuffer& queries, std::size_t first, std::size_t n, const TermsScene& scene,
                  const Dispatch& dispatch);

    std::size_t n_lanes_, n_results_;
    GlProgram see_, terms_, reduce_;
    GlBuffer lattices_, pairs_, partials_, results_;
};

}  // namespace anyrate
