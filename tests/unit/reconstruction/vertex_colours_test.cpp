#include "core/reconstruction/vertex_colours.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

constexpr double any_spacing = 1e9;  // the mesh's own edges count then

/// A tenth as wide as the edges of icosphere(3).
Vec3 fine_stripes(const Vec3& p) { return Vec3::Constant(std::sin(2 * M_PI * p.z() / 0.03) > 0 ? 200 : 50); }

/// Largest difference from a grey level, over the vertices that look at the ring of cameras.
double largest_difference(const Mesh& mesh, const std::vector<Rgb8>& colours, double grey) {
    double largest = 0;
    for (std::size_t v = 0; v < colours.size(); ++v)
        if (std::abs(mesh.vertices[v].z()) < 0.5) largest = std::max(largest, std::abs(colours[v].g - grey));
    return largest;
}

}  // namespace

TEST_CASE("Vertex spacing: the mean edge of an even mesh, at its own number of vertices and at another") {
    const Mesh sphere = icosphere(4);
    const OneRings rings(sphere);
    double mean = 0;
    for (const double edge : mean_edge_lengths(sphere, rings)) mean += edge / sphere.n_vertices();
    CHECK(vertex_spacing(sphere, sphere.n_vertices()) == doctest::Approx(mean).epsilon(0.02));
    CHECK(vertex_spacing(sphere, 4 * sphere.n_vertices()) == doctest::Approx(mean / 2).epsilon(0.02));
}

TEST_CASE("Vertex colours: what changes slowly is seen as it is, in coarse meshes and fine ones") {
    const auto ramp = [](const Vec3& p) { return Vec3(128 + 90 * p.z(), 128 + 90 * p.x(), 128 - 60 * p.y()); };
    const PhotoImages images = make_photo_images(painted_sphere(8, 200, ramp));
    const Mesh sphere = icosphere(3);
    for (const double spacing : {0.0, 0.02, any_spacing}) {
        const auto colours = vertex_colours(images, sphere, spacing);
        for (std::size_t v = 0; v < colours.size(); ++v) {
            const Vec3& p = sphere.vertices[v];
            if (std::abs(p.z()) < 0.5) CHECK(std::abs(colours[v].r - ramp(p).x()) < 4);
        }
    }
}

TEST_CASE("Vertex colours: what is finer than the mesh is averaged, not picked") {
    const PhotoImages images = make_photo_images(painted_sphere(8, 400, fine_stripes));
    const Mesh sphere = icosphere(3);
    CHECK(largest_difference(sphere, vertex_colours(images, sphere, any_spacing), 125) < 40);
    // For a mesh that will have a vertex in every pixel the stripes count.
    CHECK(largest_difference(sphere, vertex_colours(images, sphere, 0), 125) > 55);
}
