#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/capture/camera.h"
#include "core/mesh/mesh.h"

namespace anyrate {

/// A triangle as a camera sees it. The ray through pixel position (x, y) meets the triangle where the three weights
/// side[i] . (x, y, 1) have no minus; there they are the barycentric coordinates up to their sum, perspective
/// included, and their sum is proportional to the inverse depth.
/// A side's weight is computed from its two corners alone and changes nothing but its sign when they are exchanged, so
/// that between two triangles of a closed surface no ray can slip through, rounding included.
struct ProjectedTriangle {
    std::array<Vec3, 3> side;           ///< side[i] lies opposite of corner i
    double inverse_volume;              ///< inverse depth = inverse_volume * sum of the weights
    double x_min, x_max, y_min, y_max;  ///< bounds, pixels
    std::int32_t triangle;              ///< its number in the mesh
};

/// The triangles that face the camera, in the order of the mesh.
/// @param surface  closed; all its vertices in front of the camera
std::vector<ProjectedTriangle> project_triangles(const Mesh& surface, const Camera& camera);

/// The nearest triangle of every sample position in a band of pixel rows: z-buffering on a grid of samples that is
/// `supersampling` times as dense as the pixels in each direction.
class VisibleBand {
public:
    VisibleBand(int width, int first_row, int n_rows, int supersampling);

    /// Enters one triangle; of two at the same depth the one entered first stays.
    /// @param number  what nearest() gives back for it
    void draw(const ProjectedTriangle& triangle, std::int32_t number);

    /// What sample (i, j) of pixel (x, y) shows, or -1.
    std::int32_t nearest(int x, int y, int i, int j) const { return samples_[index(x, y, i, j)].number; }
    /// Where that sample is: homogeneous pixel position (x, y, 1).
    Vec3 position(int x, int y, int i, int j) const {
        return {along(x * supersampling_ + i), along(y * supersampling_ + j), 1};
    }

private:
    struct Sample {
        double inverse_depth = 0;
        std::int32_t number = -1;
    };
    /// Pixel coordinate of a column or row of samples, counted from the image's edge.
    double along(int sample) const { return (sample + 0.5) / supersampling_ - 0.5; }
    std::size_t index(int x, int y, int i, int j) const {
        return static_cast<std::size_t>((y - first_row_) * supersampling_ + j) *
                   static_cast<std::size_t>(width_ * supersampling_) +
               static_cast<std::size_t>(x * supersampling_ + i);
    }

    int width_, first_row_, n_rows_, supersampling_;
    std::vector<Sample> samples_;
};

}  // namespace anyrate
