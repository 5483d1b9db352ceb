// What a device cannot do, for real: memory that it has not, buffers larger than its shaders read, clean-up in the
// wrong place. A lost context cannot be had on demand; what follows from one is tested in fallback_backend_test.cpp.
#include <doctest/doctest.h>
#include <epoxy/gl.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/reconstruction/fallback_backend.h"
#include "gpu/egl_context.h"
#include "gpu/gl_buffer.h"
#include "gpu/gl_error.h"
#include "gpu/gpu_backend.h"
#include "tests/scenes.h"

using namespace anyrate;

namespace {

std::unique_ptr<PhotoBackend> on_any_device(const PhotoImages& images, Sampling sampling) {
    return make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images, sampling);
}

std::size_t largest_block() {
    const EglContext context(DeviceChoice::any);
    GLint64 bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    return static_cast<std::size_t>(bytes);
}

}  // namespace

TEST_CASE("GpuBackend: photographs that no device has the memory for leave the work to the CPU, with the failed call") {
    PhotoImages images;  // two terabytes of them, if there were pixels
    images.views.resize(2000);
    for (PhotoView& view : images.views) {
        view.levels.resize(1);
        view.levels[0].width = view.levels[0].height = 16'384;
    }
    std::vector<std::string> warnings;
    const auto warn = [&](const std::string& reason) { warnings.push_back(reason); };
    const auto backend = with_cpu_fallback(on_any_device, warn)(images, Sampling::adaptive);
    CHECK(backend->n_levels() == 1);
    REQUIRE(warnings.size() == 1);
    CHECK_MESSAGE(warnings[0].find("OpenGL") != std::string::npos, warnings[0]);
    CHECK_MESSAGE((warnings[0].find("glTextureStorage3D of 16384 x 16384 x 2000") != std::string::npos ||
                   warnings[0].find("layers in a texture") != std::string::npos ||
                   warnings[0].find("has the memory for") != std::string::npos),
                  warnings[0]);
}

TEST_CASE(
    "GpuBackend: a surface that the device cannot take in the middle of a job goes to the CPU with all that follows") {
    const PhotoImages images = make_photo_images(sphere_capture(64, 48), 1);
    const Mesh small = torus(0.7, 0.3, 30, 20), large = torus(0.7, 0.3, 450, 300);
    int n_warnings = 0;
    const auto backend =
        with_cpu_fallback(on_any_device, [&](const std::string&) { ++n_warnings; })(images, Sampling::adaptive);
    const auto cpu = make_cpu_backend(images);
    CHECK(measure_surface(*backend, small) == doctest::Approx(measure_surface(*cpu, small)).epsilon(1e-4));
    CHECK(n_warnings == 0);
    const bool fits = 4 * sizeof(float) * images.views.size() * large.vertices.size() <= largest_block();
    const double on_large = measure_surface(*backend, large);
    CHECK(n_warnings == (fits ? 0 : 1));
    CHECK(on_large == doctest::Approx(measure_surface(*cpu, large)).epsilon(fits ? 1e-4 : 1e-12));
    CHECK(measure_surface(*backend, small) ==
          doctest::Approx(measure_surface(*cpu, small)).epsilon(fits ? 1e-4 : 1e-12));
}

TEST_CASE("GpuBackend: destroyed on another thread it deletes nothing of that thread's context") {
    const PhotoImages images = make_photo_images(sphere_capture(4, 64), 2);
    std::unique_ptr<PhotoBackend> backend = on_any_device(images, Sampling::adaptive);
    measure_surface(*backend, icosphere(2));
    std::thread([&] {
        EglContext context(DeviceChoice::any);
        // As many as the backend has, so that each of its names is one here, too.
        std::vector<std::unique_ptr<GlBuffer>> buffers;
        for (int i = 0; i < 64; ++i) {
            buffers.push_back(std::make_unique<GlBuffer>());
            buffers.back()->write<std::uint32_t>(std::vector<std::uint32_t>(100, 7));
        }
        backend.reset();
        context.make_current();
        for (const auto& buffer : buffers) {
            std::vector<std::uint32_t> values(100);
            buffer->read<std::uint32_t>(values);
            CHECK(values == std::vector<std::uint32_t>(100, 7));
        }
    }).join();
}

TEST_CASE("check_gl_and_reset: a device that was not reset passes, a fault is told with its call") {
    const EglContext context(DeviceChoice::any);
    CHECK_NOTHROW(check_gl_and_reset("glFinish"));
    glEnable(0xFFFF);
    CHECK_THROWS_WITH(check_gl_and_reset("glFinish"), "OpenGL, glFinish: invalid enum");
}
