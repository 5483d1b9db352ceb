#include "gpu/egl_context.h"

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <thread>

#include "core/error.h"
#include "gpu/gl_buffer.h"

using namespace anyrate;

TEST_CASE("EglContext: names its device") {
    const EglContext context(DeviceChoice::any);
    CHECK(!context.device().renderer.empty());
    CHECK(!context.device().vendor.empty());
    CHECK(context.device().version.find("4.") == 0);
}

TEST_CASE("EglContext: asked for hardware, it takes none that is software and says why") {
    try {
        const EglContext context(DeviceChoice::hardware);
        CHECK(!context.device().is_software);
    } catch (const DeviceError& error) {
        const std::string message = error.what();
        CHECK_MESSAGE(message.find("no GPU with OpenGL 4.5") == 0, message);
        CHECK_MESSAGE(message.find("computes on the CPU") != std::string::npos, message);
    }
}

TEST_CASE("EglContext: two live side by side, and one outlives the other") {
    auto first = std::make_unique<EglContext>(DeviceChoice::any);
    EglContext second(DeviceChoice::any);
    first.reset();
    second.make_current();
    GlBuffer buffer;
    CHECK_NOTHROW(buffer.reserve(1000));
}

TEST_CASE("EglContext: another thread is refused") {
    EglContext context(DeviceChoice::any);
    bool is_refused = false;
    std::thread([&] {
        try {
            context.make_current();
        } catch (const DeviceError&) {
            is_refused = true;
        }
    }).join();
    CHECK(is_refused);
}
