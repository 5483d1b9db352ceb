// What a backend does in a second: the CPU, and the OpenGL device of this machine (Mesa's llvmpipe if it has no other).
// Needs no file: a painted torus is rendered first. On a machine without this project's packages: pack_backend.sh.
//
// usage: backend [--views 22] [--width 640] [--height 480] [--vertices 10000] [--repeat 5] [--cpu-only]
// prints {"machine", "scene", "backends": [{"name", "stages": {"upload", "set_surface", "distortions", "terms",
// "optimise_round"}}], "device", "roofline"}: a stage has the median of its wall seconds, dispatches and bytes moved of
// one call and, where samples are looked at, their rate (a lattice point in one view is a sample). "optimise_round" is
// a round as the refinement takes it, set_surface included: three steps of the neighbourhoods of a batch. The roofline
// says what the device does at most (measured: multiply-adds from registers, copies of memory) and what time the stages
// would take at that.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/reconstruction/optimise_round.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/sampling.h"
#include "core/reconstruction/silhouette_term.h"
#include "core/reconstruction/visibility.h"
#include "core/simulation/parametric_meshes.h"
#include "core/simulation/simulate.h"
#include "gpu/egl_context.h"
#include "gpu/gl_buffer.h"
#include "gpu/gl_program.h"
#include "gpu/gpu_backend.h"
#include "tests/bench/tool.h"

namespace anyrate {
namespace {

using bench::Json;

struct Request {
    SimulateOptions scene;
    int n_vertices = 10'000;
    int n_repeat = 5;
    bool cpu_only = false;
};

/// Operations on floats a sample in one view costs, counted in shaders/terms.comp (a multiply-add is two).
constexpr double distortion_operations = 60, term_operations = 190;

double seconds_of(const std::function<void()>& action) {
    const auto start = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

/// The surface that is looked at, and how often.
struct Subject {
    Mesh mesh;
    OneRings rings;
    Silhouettes silhouettes;
    std::vector<std::int32_t> active, around;  ///< neighbourhoods of seven vertices, and the faces around them
    std::vector<TriangleQuery> batch;
    std::vector<std::array<Vec3, 3>> directions;
    double n_samples = 0;     ///< lattice points, each in every view that sees its face
    double object_bytes = 0;  ///< of the pixels that show the object
};

/// The torus of the scene of that name, its vertices a hundredth of the tube off.
Mesh surface_of_scene(int n_vertices) {
    constexpr double major_radius = 0.75, minor_radius = 0.30;
    const int n_across = std::max(3, static_cast<int>(std::lround(std::sqrt(n_vertices / 2.5))));
    Mesh mesh = torus(major_radius, minor_radius, std::max(3, n_vertices / n_across), n_across);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        mesh.vertices[v] *= 1 + 0.01 * minor_radius * std::sin(static_cast<double>(7 * v));
    return mesh;
}

/// One-rings that share no vertex, as the splits of a batch.
std::vector<std::int32_t> neighbourhoods(const OneRings& rings, int n_vertices) {
    std::vector<char> is_active(static_cast<std::size_t>(n_vertices), 0);
    const auto active = [&](std::int32_t v) -> char& { return is_active[static_cast<std::size_t>(v)]; };
    for (std::int32_t v = 0; v < n_vertices; ++v) {
        const auto ring = rings.neighbours(v);
        if (active(v) != 0 || std::ranges::any_of(ring, [&](std::int32_t w) { return active(w) != 0; })) continue;
        active(v) = 1;
        for (const std::int32_t w : ring) active(w) = 1;
    }
    std::vector<std::int32_t> list;
    for (std::int32_t v = 0; v < n_vertices; ++v)
        if (active(v) != 0) list.push_back(v);
    return list;
}

Subject make_subject(const Simulation& simulation, const PhotoImages& images, int n_vertices) {
    Mesh mesh = surface_of_scene(n_vertices);
    OneRings rings(mesh);
    Subject subject{std::move(mesh), std::move(rings), Silhouettes(simulation.capture), {}, {}, {}, {}};
    subject.active = neighbourhoods(subject.rings, subject.mesh.n_vertices());
    subject.around = faces_around(subject.rings, subject.active);
    subject.batch = whole_surface(subject.mesh);
    subject.directions = corner_normals(subject.mesh);
    const Visibility visibility(images, subject.mesh);
    for (std::int32_t f = 0; f < subject.mesh.n_faces(); ++f) {
        const auto n_points = static_cast<double>(lattice(lattice_steps(visibility.mean_area_px(f), 1.0)).size());
        const std::size_t n_views = visibility.views(f).size();
        if (n_views >= 2) subject.n_samples += n_points * static_cast<double>(n_views);
    }
    for (const View& view : simulation.capture.views)
        subject.object_bytes +=
            4.0 * static_cast<double>(std::ranges::count_if(view.mask.pixels, [](auto m) { return m != 0; }));
    return subject;
}

/// The stages of a backend. @param device  the same backend, if it is a device
Json stages(PhotoBackend& backend, GpuBackend* device, Subject& subject, int n_repeat) {
    Json result = Json::object();
    const auto measure = [&](const char* name, double n_samples, const std::function<void()>& call) {
        const auto finished = [&] {
            call();
            if (device) device->finish();
        };
        finished();  // once for what is compiled or allocated on the way
        const DeviceWork before = device ? device->work() : DeviceWork{};
        std::vector<double> seconds;
        for (int i = 0; i < n_repeat; ++i) seconds.push_back(seconds_of(finished));
        Json stage = {{"seconds", median(seconds)}};
        if (n_samples > 0) stage["samples_per_second"] = n_samples / median(seconds);
        if (device) {
            const auto per_call = [&](std::uint64_t now, std::uint64_t then) {
                return (now - then) / static_cast<std::uint64_t>(n_repeat);
            };
            stage["dispatches"] = per_call(device->work().n_dispatches, before.n_dispatches);
            stage["bytes_up"] = per_call(device->work().bytes_up, before.bytes_up);
            stage["bytes_down"] = per_call(device->work().bytes_down, before.bytes_down);
        }
        result[name] = std::move(stage);
    };
    measure("set_surface", 0, [&] { backend.set_surface(subject.mesh, 0, 1.0); });
    measure("distortions", subject.n_samples, [&] { backend.distortions(subject.batch); });
    measure("terms", subject.n_samples, [&] { backend.terms(subject.batch, subject.directions); });
    const OptimiseOptions options{.rounds = 1, .tangential = 0, .bending = 0.01};
    const OptimiseRound round{subject.mesh.triangles, subject.rings, subject.active,     subject.around,
                              subject.around,         options,       subject.silhouettes};
    measure("optimise_round", 0, [&] {
        std::vector<Vec3> vertices = subject.mesh.vertices;
        backend.optimise_round(round, vertices, 0.1);
    });
    return result;
}

/// Multiply-adds a second from registers, times two.
double measured_operations(int n_repeat) {
    const GlProgram program("multiply-adds", R"(layout(local_size_x = 64) in;
        layout(std430, binding = 0) buffer Values { float values[]; };
        void main() {
            uint i = gl_GlobalInvocationID.x;
            vec4 a = vec4(float(i)), b = a + 0.25, c = a + 0.5, d = a + 0.75;
            for (int k = 0; k < 1024; ++k) {
                a = a * 0.999 + 0.001; b = b * 0.999 + 0.001; c = c * 0.999 + 0.001; d = d * 0.999 + 0.001;
            }
            values[i] = dot(a + b + c + d, vec4(1));
        })");
    constexpr std::size_t n = std::size_t{1} << 19;
    GlBuffer values;
    values.clear(4 * n);
    values.bind(0);
    std::vector<double> seconds;
    float last = 0;
    for (int i = 0; i <= n_repeat; ++i) {
        const double time = seconds_of([&] {
            program.run(n);
            values.read(std::span<float>(&last, 1));  // waits
        });
        if (i > 0) seconds.push_back(time);
    }
    return 1024.0 * 16 * 2 * n / median(seconds);
}

/// Bytes a second read and written by a copy that no cache holds.
double measured_bytes(int n_repeat) {
    const GlProgram program("copy", R"(layout(local_size_x = 64) in;
        layout(std430, binding = 0) readonly buffer From { vec4 from[]; };
        layout(std430, binding = 1) writeonly buffer To { vec4 to[]; };
        void main() { uint i = gl_GlobalInvocationID.x; to[i] = from[i] + 1.0; })");
    constexpr std::size_t n = (std::size_t{1} << 22) - 64;  // 64 MB; as many items as every OpenGL 4.5 dispatches
    GlBuffer from, to;
    from.clear(16 * n);
    to.clear(16 * n);
    from.bind(0);
    to.bind(1);
    constexpr int n_copies = 8;
    std::vector<double> seconds;
    float last = 0;
    for (int i = 0; i <= n_repeat; ++i) {
        const double time = seconds_of([&] {
            for (int k = 0; k < n_copies; ++k) program.run(n);
            to.read(std::span<float>(&last, 1));
        });
        if (i > 0) seconds.push_back(time);
    }
    return 2.0 * 16 * n * n_copies / median(seconds);
}

Json roofline(const Subject& subject, int n_repeat) {
    const double operations = measured_operations(n_repeat), bytes = measured_bytes(n_repeat);
    const auto stage = [&](double per_sample, double bytes_a_triangle) {
        const double needed = per_sample * subject.n_samples;
        const double moved = subject.object_bytes + bytes_a_triangle * static_cast<double>(subject.batch.size());
        return Json{{"operations", needed},
                    {"bytes", moved},
                    {"seconds_of_operations", needed / operations},
                    {"seconds_of_bytes", moved / bytes}};
    };
    return {{"operations_per_second", operations},
            {"bytes_per_second", bytes},
            {"distortions", stage(distortion_operations, 112 + 8)},
            {"terms", stage(term_operations, 112 + 68)}};
}

Json measure(const Request& request) {
    const Simulation simulation = simulate_scene("torus", request.scene);
    const PhotoImages images = make_photo_images(simulation.capture);
    Subject subject = make_subject(simulation, images, request.n_vertices);
    Json result = {{"machine", {{"cpu", cpu_name()}, {"cores", std::thread::hardware_concurrency()}}},
                   {"scene",
                    {{"views", request.scene.n_views},
                     {"width", request.scene.width},
                     {"height", request.scene.height},
                     {"vertices", subject.mesh.n_vertices()},
                     {"active", subject.active.size()},
                     {"samples", subject.n_samples}}},
                   {"backends", Json::array()}};
    const auto cpu = make_cpu_backend(images);
    result["backends"].push_back({{"name", "cpu"}, {"stages", stages(*cpu, nullptr, subject, request.n_repeat)}});
    if (request.cpu_only) return result;
    try {
        const auto context = std::make_shared<EglContext>(DeviceChoice::any);
        std::unique_ptr<GpuBackend> device;
        const double upload = seconds_of([&] {
            device = make_gpu_backend(context, images);
            device->finish();
        });
        const std::uint64_t bytes = device->work().bytes_up;
        Json times = {{"upload", {{"seconds", upload}, {"bytes_up", bytes}}}};
        times.update(stages(*device, device.get(), subject, request.n_repeat));
        result["backends"].push_back({{"name", context->device().is_software ? "llvmpipe" : "gpu"},
                                      {"device", context->device().renderer},
                                      {"driver", context->device().version},
                                      {"stages", std::move(times)}});
        device.reset();
        result["roofline"] = roofline(subject, request.n_repeat);
    } catch (const DeviceError& error) {
        result["no_device"] = error.what();
    }
    return result;
}

}  // namespace
}  // namespace anyrate

int main(int argc, char** argv) {
    CLI::App app("Measures the backends of this machine.");
    anyrate::Request request;
    app.add_option("--views", request.scene.n_views, "of the scene")->capture_default_str();
    app.add_option("--width", request.scene.width, "pixels of a view")->capture_default_str();
    app.add_option("--height", request.scene.height, "pixels of a view")->capture_default_str();
    app.add_option("--vertices", request.n_vertices, "of the surface that is looked at")->capture_default_str();
    app.add_option("--repeat", request.n_repeat, "calls of each stage")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_flag("--cpu-only", request.cpu_only, "without a device");
    return anyrate::bench::run_tool(app, argc, argv, [&] { return anyrate::measure(request); });
}
