#include <doctest/doctest.h>
#include <epoxy/gl.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/error.h"
#include "gpu/egl_context.h"
#include "gpu/gl_buffer.h"
#include "gpu/gl_error.h"
#include "gpu/gl_program.h"
#include "gpu/gl_texture_array.h"

using namespace anyrate;

namespace {

/// The message of the DeviceError that an action ends with; empty if it ends without.
template <class Action>
std::string failure_of(const Action& action) {
    try {
        action();
    } catch (const DeviceError& error) {
        return error.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("GlBuffer: gives back what was written, also after it had to grow") {
    const EglContext context(DeviceChoice::any);
    GlBuffer buffer;
    buffer.write<std::uint32_t>(std::vector<std::uint32_t>(10, 7));
    std::vector<std::uint32_t> many(10'000);
    for (std::uint32_t i = 0; i < many.size(); ++i) many[i] = i * i;
    buffer.write<std::uint32_t>(many);
    std::vector<std::uint32_t> back(many.size());
    buffer.read<std::uint32_t>(back);
    CHECK(back == many);
    buffer.clear(4 * back.size());
    buffer.read<std::uint32_t>(back);
    CHECK(back == std::vector<std::uint32_t>(many.size(), 0));
}

TEST_CASE("GlBuffer: more than a shader can read is an error that says how much that is") {
    const EglContext context(DeviceChoice::any);
    GlBuffer buffer;
    CHECK(contains(failure_of([&] { buffer.reserve(std::size_t{1} << 50); }), "no more than"));
}

TEST_CASE("GlProgram: runs for every item of every row") {
    const EglContext context(DeviceChoice::any);
    const GlProgram square("square",
                           R"(layout(local_size_x = 64) in;
                              layout(std430, binding = 0) buffer Values { uint values[]; };
                              layout(location = 0) uniform int n;
                              void main() {
                                  uint i = gl_GlobalInvocationID.x, row = gl_WorkGroupID.y;
                                  if (i < uint(n)) values[row * uint(n) + i] = BIAS + i * i + row;
                              })",
                           "#define BIAS 5u\n");
    constexpr std::size_t n = 100, rows = 3;
    GlBuffer buffer;
    buffer.clear(4 * rows * n);
    buffer.bind(0);
    square.set(0, static_cast<std::int32_t>(n));
    square.run(n, rows);
    std::vector<std::uint32_t> values(rows * n);
    buffer.read<std::uint32_t>(values);
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t i = 0; i < n; ++i) CHECK(values[row * n + i] == 5 + i * i + row);
}

TEST_CASE("GlProgram: a shader that the compiler refuses is an error with its name and the line") {
    const EglContext context(DeviceChoice::any);
    const std::string said =
        failure_of([] { GlProgram("broken", "layout(local_size_x = 64) in;\nvoid main() { x = 1; }\n"); });
    CHECK_MESSAGE(contains(said, "compiling broken"), said);
    CHECK_MESSAGE((contains(said, ":2") || contains(said, "(2)")), said);  // as Mesa and as NVIDIA count lines
}

TEST_CASE("GlProgram: more items than a dispatch takes are an error") {
    const EglContext context(DeviceChoice::any);
    const GlProgram nothing("nothing", "layout(local_size_x = 64) in; void main() {}");
    CHECK(contains(failure_of([&] { nothing.run(std::size_t{1} << 40); }), "nothing"));
}

TEST_CASE("GlTextureArray: a shader finds each pixel on its layer and level") {
    const EglContext context(DeviceChoice::any);
    GlTextureArray texture(8, 4, 2, 2);
    const std::vector<std::uint32_t> fine{1, 2, 3, 4, 5, 6}, coarse{70, 80};
    texture.write(0, 1, 3, 2, fine.data());
    texture.write(1, 0, 2, 1, coarse.data());
    const GlProgram look("look", R"(layout(local_size_x = 64) in;
        layout(binding = 0) uniform usampler2DArray pixels;
        layout(std430, binding = 0) buffer Values { uint values[]; };
        void main() {
            int i = int(gl_GlobalInvocationID.x);
            if (i < 6) values[i] = texelFetch(pixels, ivec3(i % 3, i / 3, 1), 0).r;
            else if (i < 8) values[i] = texelFetch(pixels, ivec3(i - 6, 0, 0), 1).r;
        })");
    GlBuffer buffer;
    buffer.clear(4 * 8);
    buffer.bind(0);
    texture.bind_sampler(0);
    look.run(8);
    std::vector<std::uint32_t> values(8);
    buffer.read<std::uint32_t>(values);
    CHECK(values == std::vector<std::uint32_t>{1, 2, 3, 4, 5, 6, 70, 80});
}

TEST_CASE("GlTextureArray: a size that no device has is an error that says what it has") {
    const EglContext context(DeviceChoice::any);
    CHECK(contains(failure_of([] { GlTextureArray(1 << 20, 16, 1, 1); }), "columns"));
}

TEST_CASE("check_gl: a fault is an error that names the call, once") {
    const EglContext context(DeviceChoice::any);
    glEnable(0xFFFF);
    CHECK(contains(failure_of([] { check_gl("glEnable"); }), "glEnable: invalid enum"));
    CHECK_NOTHROW(check_gl("glEnable"));
}
