#pragma once
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/reconstruction/distortion.h"
#include "core/reconstruction/photo_backend.h"

namespace anyrate {

/// The distortions of a mesh's faces on the photographs themselves, of which only those around what moved are measured
/// again: what a moved part hides elsewhere or no longer hides is nothing to whether that part itself agrees.
class FaceDistortions {
public:
    /// @param backend  outlives this
    FaceDistortions(PhotoBackend& backend, const Mesh& mesh);

    /// @param moved  vertices of `mesh`, which has the faces of the mesh that was measured whole; ascending
    void measure_around(std::span<const std::int32_t> moved, const Mesh& mesh, const OneRings& rings);

    /// Those of another mesh with the same faces, for faces that have come to look like there.
    template <class IsTaken>
    void take(const FaceDistortions& other, const IsTaken& is_taken) {
        for (std::size_t f = 0; f < faces_.size(); ++f)
            if (is_taken(static_cast<std::int32_t>(f))) faces_[f] = other.faces_[f];
    }

    std::span<const TriangleDistortion> faces() const { return faces_; }

    /// G (Nghiem et al., Eq. 9) of every vertex, squared colour units; none where no two views see it.
    std::vector<std::optional<double>> of_vertices(const OneRings& rings, int n_vertices) const;

private:
    PhotoBackend* backend_;
    std::vector<TriangleDistortion> faces_;
};

/// Median of G (Eq. 9, squared colour units) over the vertices that have one and are not left out; nothing if there is
/// none.
/// @param left_out  one flag a vertex
std::optional<double> usual_distortion(std::span<const std::optional<double>> G, std::span<const char> left_out);

}  // namespace anyrate
