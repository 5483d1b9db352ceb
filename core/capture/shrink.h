#pragma once
#include "core/capture/image.h"

namespace anyrate {

/// A small copy of an image: each pixel is the mean of those that it stands for.
/// @param longest  pixels of its longer side, at least 1; an image that is no longer stays as it is
ColourImage shrink(const ColourImage& image, int longest);

}  // namespace anyrate
