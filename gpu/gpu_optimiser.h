#pragma once
#include <span>
#include <vector>

#include "core/reconstruction/optimise_round.h"
#include "gpu/device_silhouettes.h"
#include "gpu/device_terms.h"

namespace anyrate {

/// Takes the steps of a round of optimise_surface() on the device: terms, the damped Gauss-Newton step by conjugate
/// gradients, the energy, and whether the step is taken or rolled back and damped more. All that may come is given to
/// the device at once, as indirect dispatches; it decides by itself which of them take place, so that nothing comes
/// back before the vertices do.
class GpuOptimiser {
public:
    /// @throws DeviceError
    explicit GpuOptimiser(const GraphicsDevice& device);

    /// As PhotoBackend::optimise_round(), but that the round's surface is the device's current one already.
    /// @param surface      its vertices are moved
    /// @param terms        with derivatives; of the round's level in `scene`, which shows `surface`
    /// @param pixel_sizes  of the level at each face around an active vertex, world units
    /// @throws DeviceError `vertices` are then as they were
    RoundOutcome run(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping, GpuSurface& surface,
                     DeviceTerms& terms, const TermsScene& scene, std::span<const double> pixel_sizes,
                     DeviceWork& work);

private:
    struct Sequence;

    DeviceSilhouettes silhouettes_;
    GlProgram normals_, gather_, contours_, assemble_, solve_, move_, weigh_, judge_;
    GlBuffer head_, structure_, vertex_normals_, data_, control_, queries_, entries_;
};

}  // namespace anyrate
