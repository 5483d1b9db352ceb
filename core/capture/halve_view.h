#pragma once
#include "core/capture/capture.h"

namespace anyrate {

/// The view half as wide and high, as a camera with pixels of twice the side has it: a pixel's colour is the mean of
/// four, and it is the object's if two of them are. The last of an odd number of columns or rows is left out.
/// @param view  at least two pixels wide and high
void halve(View& view);

}  // namespace anyrate
