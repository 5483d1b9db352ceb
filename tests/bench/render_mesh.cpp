// Pictures of meshes side by side, from a camera of a capture, each face shaded by its own normal so that the triangles
// show; the photograph last if asked for. Cut to the object.
//
// usage: render_mesh CAPTURE -o OUT.png [--cameras FILE] [--view I] [--height PX] [--photo] MESH...
// prints {"width", "height", "panels"}
#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/capture/image_io.h"
#include "core/capture/load_capture.h"
#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "core/simulation/render.h"
#include "tests/bench/image_window.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;

struct Request {
    std::filesystem::path capture, output;
    LoadOptions load;
    int view = 0, height = 360;
    bool photo = false;
    std::vector<std::string> meshes;
};

/// The mesh with corners of its own for every face, so that a normal belongs to one face.
Model faceted_clay(const Mesh& mesh, const Camera& camera) {
    Model model;
    for (const Triangle& t : mesh.triangles) {
        const auto n = static_cast<std::int32_t>(model.surface.vertices.size());
        const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        model.surface.vertices.insert(model.surface.vertices.end(), {a, b, c});
        model.surface.triangles.push_back({n, n + 1, n + 2});
        model.normals.insert(model.normals.end(), 3, (b - a).cross(c - a).normalized());
    }
    // From behind the camera, above and to the left of it.
    const Vec3 light = camera.R.transpose() * Vec3(-0.45, -0.55, -0.7).normalized();
    model.appearance = [light](const Vec3&, const Vec3& normal) {
        const double brightness =
            0.06 + 0.62 * std::max(0.0, normal.dot(light)) + 0.08 * (0.5 + 0.5 * normal.dot(light));
        return Vec3(brightness * Vec3(1.0, 0.97, 0.92));
    };
    return model;
}

void paste(const ColourImage& panel, ColourImage& sheet, int left) {
    for (int y = 0; y < panel.height; ++y)
        for (int x = 0; x < panel.width; ++x) sheet(left + x, y) = panel(x, y);
}

void write_png(const ColourImage& image, const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = encode_png(image);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw IoError(path.string() + ": cannot be written");
}

bench::Json render(const Request& request) {
    const Capture capture = load_capture(request.capture, request.load);
    if (request.view < 0 || request.view >= static_cast<int>(capture.views.size()))
        throw InputError("view: expected 0 to " + std::to_string(capture.views.size() - 1) + ", got " +
                         std::to_string(request.view));
    const View& view = capture.views[static_cast<std::size_t>(request.view)];
    const bench::Window window = bench::window_of_object(view.mask, 0.04);
    const int width = static_cast<int>(std::lround(window.width / window.height * request.height));
    const Camera camera = bench::look_through(view.camera, window, width, request.height);

    std::vector<ColourImage> panels;
    for (const std::string& file : request.meshes)
        panels.push_back(render_view(faceted_clay(read_mesh(file), camera), camera, "", {.noise = 0}).image);
    if (request.photo) panels.push_back(bench::look_through(view, window, width, request.height).image);
    if (panels.empty()) throw InputError("expected a mesh, or --photo");
    ColourImage sheet(static_cast<int>(panels.size()) * width, request.height);
    for (std::size_t i = 0; i < panels.size(); ++i) paste(panels[i], sheet, static_cast<int>(i) * width);
    write_png(sheet, request.output);
    return {{"width", sheet.width}, {"height", sheet.height}, {"panels", panels.size()}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Renders meshes side by side.");
    Request request;
    app.add_option("CAPTURE", request.capture, "folder or zip")->required();
    app.add_option("MESH", request.meshes, "meshes (.ply or .obj), left to right");
    app.add_option("-o,--output", request.output, "PNG to write")->required();
    app.add_option("--cameras", request.load.cameras_file, "name of the camera file")->capture_default_str();
    app.add_option("--view", request.view, "whose camera")->capture_default_str();
    app.add_option("--height", request.height, "of the picture, pixels")
        ->check(CLI::Range(16, 8192))
        ->capture_default_str();
    app.add_flag("--photo", request.photo, "the photograph as the last panel");
    return bench::run_tool(app, argc, argv, [&] { return render(request); });
}
