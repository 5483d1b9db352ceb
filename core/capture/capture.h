#pragma once
#include <string>
#include <vector>

#include "core/capture/camera.h"
#include "core/capture/image.h"

namespace anyrate {

/// One photograph: its camera, colours and segmentation, all of the same size in pixels.
struct View {
    std::string name;  ///< the image file's name inside the capture, for messages
    Camera camera;
    ColourImage image;
    MaskImage mask;
};

/// Calibrated, segmented photographs of one object: at least three views (load_capture() checks all promises).
struct Capture {
    std::string name;
    std::vector<View> views;
    int n_halvings = 0;  ///< how often the loader halved width and height of all photographs, see LoadOptions
};

}  // namespace anyrate
