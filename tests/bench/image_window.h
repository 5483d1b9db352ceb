#pragma once
#include "core/capture/capture.h"

namespace anyrate::bench {

/// A part of an image, in pixels whose centres are integers (camera.h): [x, x + width] x [y, y + height], so the whole
/// image begins at (-0.5, -0.5).
struct Window {
    double x = -0.5, y = -0.5, width = 0, height = 0;
};

/// The window of a view as a view of its own, `width` x `height` pixels large: colours averaged over each pixel, the
/// mask set where at least half of the pixel is, the camera looking at the same world. Outside of the image is
/// background.
View look_through(const View& view, const Window& window, int width, int height);

/// The same for the camera alone.
Camera look_through(const Camera& camera, const Window& window, int width, int height);

/// The smallest window that holds a mask, widened by `margin` of its larger side all around. @pre the mask is not empty
Window window_of_object(const MaskImage& mask, double margin);

}  // namespace anyrate::bench
