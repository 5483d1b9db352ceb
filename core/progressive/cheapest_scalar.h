#pragma once
#include <cstdint>

namespace anyrate {

/// The scalar of least distortion plus bits times their price: nearly the nearest one where a vertex matters, a smaller
/// one or 0 where it does not.
/// @param steps       the way to the target
/// @param step_cost   distortion of one step off the target; it grows with the square
/// @param bit_price   distortion that a bit is worth, above 0
/// @param is_new      a residual of a new vertex; else an update, of which most are 0
std::int32_t cheapest_scalar(double steps, double step_cost, double bit_price, bool is_new);

}  // namespace anyrate
