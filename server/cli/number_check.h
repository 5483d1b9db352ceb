#pragma once

namespace CLI {
class Validator;
}

namespace anyrate {

/// Accept a finite number above 0, or one that is not below it; anything else is wrong usage.
CLI::Validator above_zero();
CLI::Validator not_below_zero();

}  // namespace anyrate
