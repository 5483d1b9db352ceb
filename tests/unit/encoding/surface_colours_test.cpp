#include "core/encoding/surface_colours.h"

#include <doctest/doctest.h>

#include "core/simulation/parametric_meshes.h"

using namespace anyrate;

TEST_CASE("Surface colours: between coloured vertices the colours are interpolated") {
    Mesh mesh = icosphere(3);
    for (const Vec3& v : mesh.vertices)
        mesh.colours.push_back(
            {static_cast<std::uint8_t>(127 + 120 * v.x()), 80, static_cast<std::uint8_t>(127 + 120 * v.z())});
    const NearestSurface nearest(mesh);
    const std::vector<Vec3> points{{1.2, 0, 0}, {0, 0.9, 0}, {0.6, 0, -0.8}};
    const std::vector<Rgb8> colours = surface_colours(mesh, nearest, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 on = points[i].normalized();
        CHECK(colours[i].r == doctest::Approx(127 + 120 * on.x()).epsilon(0.02));
        CHECK(colours[i].g == 80);
        CHECK(colours[i].b == doctest::Approx(127 + 120 * on.z()).epsilon(0.1));
    }
    CHECK(surface_colours(icosphere(1), nearest, points).empty());
}
