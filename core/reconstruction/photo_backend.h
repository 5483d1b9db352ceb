#pragma once
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/reconstruction/distortion.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/sampling.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// One triangle whose distortion is asked for: a face of the current surface with its corners where they are to be
/// tried. Which views see it, how densely it is sampled and what its corners' valences are comes from the face.
struct TriangleQuery {
    std::int32_t face = 0;
    std::array<Vec3, 3> corners;
};

/// A triangle's distortion as a function of three scalars u: corner a stands at corners[a] + u[a] directions[a].
struct TriangleTerms {
    TriangleDistortion distortion;
    std::array<double, 3> gradient{};  ///< d phi / d u
    std::array<double, 6> hessian{};   ///< Gauss-Newton part of d2 phi / du2: 00, 11, 22, 01, 12, 20
    /// The same for a fourth, fifth and sixth scalar, which would move the middles of the edges 01, 12, 20 as a split
    /// does: what a split here could gain.
    std::array<double, 3> middle_gradient{}, middle_hessian{};
};

struct OptimiseRound;  // optimise_round.h
class Visibility;      // visibility.h

/// How a round of local optimisation ended.
struct RoundOutcome {
    bool falls = false;  ///< whether a step was taken by which the energy falls by enough to go on
    double damping = 0;  ///< to begin the next round with
    /// Whether phi is curved less than noise alone would make it: the mean over the vertices that the images say
    /// anything of. All that they say has to be gathered from far around.
    bool is_faint = false;
};

/// The seam to the GPU is the algorithm: a batch of triangles in, their distortions out. Implementations hold the
/// images and the visibility of the current surface; every result is in the order of the batch and the same for any
/// number of threads. One contract suite runs on all of them (tests/contract/photo_backend_contract.h).
class PhotoBackend {
public:
    virtual ~PhotoBackend() = default;

    /// Makes `surface` the current one: renders its visibility at once and copies what later calls need of it.
    /// @param level           pyramid level of the samples, 0 the photographs
    /// @param samples_per_px  the constant C of Nghiem et al., Eq. 7, per pixel of that level
    /// @param faces           that later calls ask for, ascending; empty is all
    virtual void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                             std::span<const std::int32_t> faces = {}) = 0;

    /// phi and samples (Eqs. 5-8) of each triangle of the batch.
    virtual std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) = 0;

    /// The same with derivatives along `directions` (unit vectors, one per corner: the vertex normals).
    virtual std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                             std::span<const std::array<Vec3, 3>> directions) = 0;

    /// A round of optimise_surface(): makes the surface the current one as set_surface() does, and moves the active
    /// vertices of all its neighbourhoods together by up to `steps_per_round` steps. This default is the rule: it asks
    /// terms() at each trial and does all else on the CPU. A device may take all steps of the round by itself and give
    /// back no more than where the vertices went.
    /// @param vertices  of the surface; the active ones are moved. Where it throws they may be anywhere
    /// @param damping   of the first step
    virtual RoundOutcome optimise_round(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping);

    /// World size of a pixel of the current level at a face of the current surface.
    virtual double pixel_size(std::int32_t face) const = 0;

    virtual int n_levels() const = 0;

    /// What set_surface() rendered, until it is called again, for who needs the visibility of that surface besides;
    /// nullptr if it is not at hand on the CPU.
    virtual const Visibility* visibility() const { return nullptr; }
};

/// The reference implementation, on oneTBB. `images` must outlive it.
std::unique_ptr<PhotoBackend> make_cpu_backend(const PhotoImages& images, Sampling sampling = Sampling::adaptive);

/// How a reconstruction gets a backend once its photographs are prepared. The pixels of `images` stay as they are while
/// the backend lives; their cameras may move between two calls of set_surface().
using BackendFactory = std::function<std::unique_ptr<PhotoBackend>(const PhotoImages& images, Sampling sampling)>;

/// A face of the surface where it stands.
TriangleQuery query_of(const SurfaceView& surface, std::int32_t face);

/// Every face of the surface where it stands, in order.
std::vector<TriangleQuery> whole_surface(const SurfaceView& surface);

/// For each face its vertices' unit normals: the directions that terms() of the whole surface is mostly asked along.
std::vector<std::array<Vec3, 3>> corner_normals(const SurfaceView& surface);

/// Psi (Nghiem et al., Eq. 10) of a surface at the photographs' own resolution. It becomes the backend's current one.
double measure_surface(PhotoBackend& backend, const SurfaceView& surface, double samples_per_px = 1.0);

}  // namespace anyrate
