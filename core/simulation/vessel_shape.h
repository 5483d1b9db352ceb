#pragma once
#include <optional>

#include "core/types.h"

namespace anyrate {

/// A place on or near one of the two handles, in its own coordinates.
struct HandlePoint {
    double distance;  ///< to the handle's centre line
    double along;     ///< length of the centre line from the neck to here
    double around;    ///< angle around the centre line
};
/// Nothing where no handle is near.
std::optional<HandlePoint> on_handle(const Vec3& point);

/// How far the handle's twisted strands stand out at a place, 0 in the grooves, 1 on a strand.
double strands(const HandlePoint& place);

/// The demo's object: a carved amphora with two rope handles (genus 2), a wide mouth over an open cavity, tongues,
/// pearls, a vine frieze and eggs in relief. The axis is z, from -1 to 1; it fits into [-0.8, 0.8] x [-0.7, 0.7] x
/// [-1.05, 1.05].
double vessel_field(const Vec3& point);

}  // namespace anyrate
