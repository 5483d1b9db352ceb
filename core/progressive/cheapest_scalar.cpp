#include "core/progressive/cheapest_scalar.h"

#include <cmath>
#include <cstdlib>
#include <initializer_list>

namespace anyrate {
namespace {

/// About what Draco's tables spend on a scalar. Only differences count, and those hardly depend on the model.
double bits_of(std::int32_t scalar, bool is_new) {
    if (scalar == 0) return is_new ? 2.5 : 0.8;
    const double magnitude = std::log2(std::abs(scalar));
    return is_new ? 3.0 + 1.3 * magnitude : 2.8 + 1.6 * magnitude;
}

}  // namespace

std::int32_t cheapest_scalar(double steps, double step_cost, double bit_price, bool is_new) {
    const auto inner = static_cast<std::int32_t>(std::trunc(steps));  // of the two around it, the one nearer to 0
    const std::int32_t sign = steps < 0 ? -1 : 1;
    std::int32_t best = 0;
    double least = step_cost * steps * steps + bit_price * bits_of(0, is_new);
    for (const std::int32_t scalar : {inner / 2, inner == 0 ? 0 : inner - sign, inner, inner + sign}) {
        const double miss = steps - scalar;
        const double cost = step_cost * miss * miss + bit_price * bits_of(scalar, is_new);
        if (cost < least) {
            least = cost;
            best = scalar;
        }
    }
    return best;
}

}  // namespace anyrate
