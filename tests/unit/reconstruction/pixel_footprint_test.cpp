#include "core/reconstruction/pixel_footprint.h"

#include <doctest/doctest.h>

#include "core/mesh/remesh.h"
#include "core/simulation/parametric_meshes.h"
#include "eq_test_scenes.h"

using namespace anyrate;

namespace {

PhotoImages photographs(int size_px) { return make_photo_images(painted_sphere(6, size_px, wavy_paint), 1); }

double mean_edge(const Mesh& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            sum += (mesh.vertices[static_cast<std::size_t>(t[k])] -
                    mesh.vertices[static_cast<std::size_t>(t[(k + 1) % 3])])
                       .norm();
    return sum / (3.0 * mesh.n_faces());
}

}  // namespace

TEST_CASE("Pixel footprint: what a pixel covers is its distance over the focal length") {
    const PhotoImages images = photographs(64);
    const Vec3 place(0.1, 0.2, -0.3);
    double sum = 0;
    for (const PhotoView& view : images.views) sum += (view.centre - place).norm() / view.focal_px;
    CHECK(pixel_footprint(place, images) == doctest::Approx(sum / 6));
    CHECK(pixel_footprint(place, photographs(128)) == doctest::Approx(sum / 12));
}

TEST_CASE("Resolved vertices: a mesh of so many has edges of four pixels, however large the photographs are") {
    for (const int size_px : {128, 256}) {
        const PhotoImages images = photographs(size_px);
        const Mesh sphere = icosphere(5);
        const Mesh even = remesh_isotropic(sphere, {.n_vertices = resolved_vertices(sphere, images)});
        CHECK(mean_edge(even) / pixel_footprint(Vec3::Zero(), images) == doctest::Approx(4).epsilon(0.05));
    }
}
