// How near a coloured mesh comes to the photographs of a capture: every view is painted with the vertex colours,
// interpolated over the faces, and compared where both the mesh and the object alone are seen.
//
// usage: photo_difference MESH CAPTURE [--cameras FILE]
// prints {"mean", "rms": differences of a channel, 0 to 255; "sharpness": differences of neighbouring pixels in the
// paintings over those in the photographs, which have noise besides; "pixels"}
#include <cmath>

#include "core/capture/load_capture.h"
#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "core/simulation/visible_surface.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;

struct Sums {
    double absolute = 0, squared = 0, steps = 0, photo_steps = 0;
    std::int64_t n_pixels = 0;
};

Vec3 as_vector(const Rgb8& c) { return {double(c.r), double(c.g), double(c.b)}; }

/// What the view sees, per pixel; a negative red where it sees none of the mesh.
std::vector<Vec3> paint(const Mesh& mesh, const View& view) {
    const int width = view.image.width, height = view.image.height;
    const std::vector<ProjectedTriangle> triangles = project_triangles(mesh, view.camera);
    VisibleBand band(width, 0, height, 1);
    for (std::size_t i = 0; i < triangles.size(); ++i) band.draw(triangles[i], static_cast<std::int32_t>(i));
    std::vector<Vec3> painted(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Vec3(-1, 0, 0));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::int32_t seen = band.nearest(x, y, 0, 0);
            if (seen < 0) continue;
            const ProjectedTriangle& triangle = triangles[static_cast<std::size_t>(seen)];
            const Triangle& corners = mesh.triangles[static_cast<std::size_t>(triangle.triangle)];
            Vec3 colour = Vec3::Zero();
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double weight = triangle.side[k].dot(band.position(x, y, 0, 0));
                colour += weight * as_vector(mesh.colours[static_cast<std::size_t>(corners[k])]);
                sum += weight;
            }
            painted[static_cast<std::size_t>(y * width + x)] = colour / sum;
        }
    return painted;
}

/// Whether a pixel and its neighbours are the object's alone, so that no background is mixed in.
bool is_inside(const MaskImage& mask, int x, int y) {
    for (int j = y - 1; j <= y + 1; ++j)
        for (int i = x - 1; i <= x + 1; ++i)
            if (!mask.contains(i, j) || mask(i, j) == 0) return false;
    return true;
}

void compare(const Mesh& mesh, const View& view, Sums& sums) {
    const std::vector<Vec3> painted = paint(mesh, view);
    const int width = view.image.width;
    const auto at = [&](int x, int y) -> const Vec3& { return painted[static_cast<std::size_t>(y * width + x)]; };
    const auto counts = [&](int x, int y) { return is_inside(view.mask, x, y) && at(x, y).x() >= 0; };
    for (int y = 1; y + 1 < view.image.height; ++y)
        for (int x = 1; x + 1 < width; ++x) {
            if (!counts(x, y)) continue;
            const Vec3 photo = as_vector(view.image(x, y)), difference = at(x, y) - photo;
            ++sums.n_pixels;
            sums.absolute += difference.cwiseAbs().sum() / 3;
            sums.squared += difference.squaredNorm() / 3;
            if (!counts(x + 1, y)) continue;
            sums.steps += (at(x + 1, y) - at(x, y)).cwiseAbs().sum();
            sums.photo_steps += (as_vector(view.image(x + 1, y)) - photo).cwiseAbs().sum();
        }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Compares a mesh's colours with the photographs of a capture.");
    std::string input, folder;
    LoadOptions load;
    app.add_option("MESH", input, "closed mesh with colours (.ply)")->required();
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    return bench::run_tool(app, argc, argv, [&]() -> bench::Json {
        const Mesh mesh = read_mesh(input);
        if (mesh.colours.empty()) throw InputError(input + ": expected a mesh with colours");
        Sums sums;
        for (const View& view : load_capture(folder, load).views) compare(mesh, view, sums);
        if (sums.n_pixels == 0) throw InputError("no view of " + folder + " sees the mesh");
        const auto n = static_cast<double>(sums.n_pixels);
        return {{"mean", sums.absolute / n},
                {"rms", std::sqrt(sums.squared / n)},
                {"sharpness", sums.steps / sums.photo_steps},
                {"pixels", sums.n_pixels}};
    });
}
