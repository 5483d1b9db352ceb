// The main function of tests that use a device.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <optional>

#include "core/error.h"
#include "gpu/egl_context.h"

#ifdef ANYRATE_SANITIZED
#include <sanitizer/lsan_interface.h>
#endif

using namespace anyrate;

int main(int n_arguments, char** arguments) {
    // While a context lives its driver stays loaded. Mesa's leaves memory behind whenever it is unloaded (22.3 on AMD
    // processors: the masks of the cores that share a cache), which is no leak of ours.
    std::optional<EglContext> held;
    try {
        held.emplace(DeviceChoice::any);
        EglContext::make_none_current();
    } catch (const DeviceError&) {
        // The tests say so, each for itself.
    }
    const int result = doctest::Context(n_arguments, arguments).run();
#ifdef ANYRATE_SANITIZED
    __lsan_do_leak_check();
#endif
    return result;
}
