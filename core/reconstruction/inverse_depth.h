#pragma once
#include <span>
#include <vector>

#include "core/capture/image.h"
#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/pixel_box.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {

/// A vertex as a view sees it: the pixel, and 1 / depth along the optical axis, which is linear on the screen across a
/// triangle; 0 for what lies behind the camera.
struct ScreenVertex {
    float x = 0, y = 0, inverse_depth = 0;
};

/// Every vertex of the surface in the camera of a level.
std::vector<ScreenVertex> project(const PhotoLevel& level, const SurfaceView& surface);

/// The same of some vertices; the others are left behind the camera.
std::vector<ScreenVertex> project(const PhotoLevel& level, const SurfaceView& surface,
                                  std::span<const std::int32_t> some);

/// Inverse depth of the nearest surface at every pixel, 1 / world units along the optical axis; 0 where there is none.
/// Faces that look away are left out: the nearest part of a closed surface always looks at the camera.
/// @param vertices  project() of the surface at the level whose size is asked for
Image<float> render_inverse_depth(int width, int height, std::span<const ScreenVertex> vertices,
                                  std::span<const Triangle> triangles);

/// A part of such an image.
struct InverseDepthPart {
    int x = 0, y = 0;     ///< of its first pixel in the whole image
    Image<float> pixels;  ///< in the box that was asked for those of the whole image, around it some may lack surface
};

/// The same, to the bit, but only where it is asked for.
/// @param box  not empty, within the image
InverseDepthPart render_inverse_depth_in(const PixelBox& box, int width, int height,
                                         std::span<const ScreenVertex> vertices, std::span<const Triangle> triangles);

/// Draws triangles over what such a part shows: the nearer one of both stays.
/// @param box  as the part was rendered in
void draw_inverse_depth(const PixelBox& box, int width, int height, std::span<const ScreenVertex> vertices,
                        std::span<const Triangle> triangles, InverseDepthPart& part);

/// Draws every surface one pixel further, over what lies far behind it: each pixel becomes the larger of its own
/// inverse depth and `far_part` of the largest among its eight neighbours.
/// @param far_part  0 to 1: of a surface's inverse depth, what one has that counts as far behind it; see far_part() of
///                  visibility.h
void widen_far_contours(InverseDepthPart& part, float far_part);

/// Each pixel becomes the largest of itself, the one right of it, the one below and the one between these: what hides
/// most of a point among the four. The last row and column have no such point and stay.
void take_largest_of_four(Image<float>& depth);

/// The pixels of an image that triangles between some vertices can reach, and one around; empty where that is none.
PixelBox pixels_around(std::span<const ScreenVertex> vertices, int width, int height);

/// The triangles that may have pixels in a box, in their order.
std::vector<Triangle> triangles_at(const PixelBox& box, std::span<const ScreenVertex> vertices,
                                   std::span<const Triangle> triangles);

/// The whole image from the surface itself.
Image<float> render_inverse_depth(const PhotoLevel& level, const SurfaceView& surface);

}  // namespace anyrate
