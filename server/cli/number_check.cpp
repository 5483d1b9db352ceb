#include "server/cli/number_check.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace anyrate {
namespace {

template <class Accepts>
CLI::Validator number(const std::string& expected, const std::string& name, Accepts accepts) {
    return CLI::Validator(
        [=](const std::string& text) -> std::string {
            double value = 0;
            const bool is_good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && accepts(value);
            return is_good ? std::string() : "expected " + expected + ", got " + text;
        },
        name, name);
}

}  // namespace

CLI::Validator above_zero() {
    return number("a number above 0", "POSITIVE", [](double x) { return x > 0; });
}

CLI::Validator not_below_zero() {
    return number("0 or a number above it", "NONNEGATIVE", [](double x) { return x >= 0; });
}

}  // namespace anyrate
