#pragma once
#include <cstdint>

#include "core/simulation/solid_texture.h"

namespace anyrate {

/// The painting of the carved vessel (vessel_shape.h), in its coordinates: glazes of cobalt, ivory, ochre and red in
/// the zones of vessel_ornament.h, a Greek key, rosettes and scales, worn and crackled.
SolidTexture vessel_paint(std::uint64_t seed);

}  // namespace anyrate
