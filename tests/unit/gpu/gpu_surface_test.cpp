#include "gpu/gpu_surface.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/reconstruction/visibility.h"
#include "gpu/egl_context.h"
#include "tests/scenes.h"
#include "tests/unit/gpu/random_surfaces.h"

using namespace anyrate;

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

TEST_CASE("GpuSurface: sees in each view the faces that Visibility sees, whole where that does") {
    const EglContext context(DeviceChoice::any);
    const PhotoImages images = make_photo_images(sphere_capture(9, 200), 4);
    DeviceWork work;
    GpuSurface surface(images);
    int n_sights = 0, n_partly = 0;
    for (const RandomSurface& random : random_surfaces()) {
        CAPTURE(random.name);
        for (int level = 0; level < images.n_levels(); ++level) {
            CAPTURE(level);
            VisibilityOptions options;
            options.finest_level = std::max(level - 1, options.finest_level);
            const Visibility expected(images, random.mesh, options);
            surface.set(random.mesh, level, 1.0, {}, Sampling::adaptive, work);
            const auto faces = surface.read_faces(work);
            const auto sights = surface.read_sights(work);
            for (std::int32_t f = 0; f < random.mesh.n_faces(); ++f) {
                CAPTURE(f);
                const auto views = expected.views(f);
                REQUIRE(at(faces[at(f)].n_views) == views.size());
                for (std::size_t i = 0; i < views.size(); ++i) {
                    CHECK(sights[at(f) * images.views.size() + i] == 2 * views[i].view + (views[i].whole ? 1 : 0));
                    ++n_sights;
                    n_partly += views[i].whole ? 0 : 1;
                }
                CHECK(faces[at(f)].area_px == doctest::Approx(expected.mean_area_px(f)).epsilon(1e-6));
                CHECK(faces[at(f)].steps == lattice_steps(std::ldexp(expected.mean_area_px(f), -2 * level), 1.0));
            }
        }
    }
    CHECK(n_partly > 100);
    CHECK(n_sights > 3 * n_partly);
}

TEST_CASE("GpuSurface: says nothing of faces that were not asked for, which hide what they hide") {
    const EglContext context(DeviceChoice::any);
    const PhotoImages images = make_photo_images(sphere_capture(6, 128), 3);
    const Mesh mesh = random_surfaces()[1].mesh;
    DeviceWork work;
    GpuSurface surface(images);
    surface.set(mesh, 0, 1.0, {}, Sampling::adaptive, work);
    const auto all = surface.read_faces(work);
    const std::vector<std::int32_t> asked{3, 50, 51, 700};
    surface.set(mesh, 0, 1.0, asked, Sampling::adaptive, work);
    const auto some = surface.read_faces(work);
    std::vector<char> is_asked(all.size(), 0);
    for (std::int32_t f : asked) is_asked[at(f)] = 1;
    for (std::size_t f = 0; f < all.size(); ++f) CHECK(some[f].n_views == (is_asked[f] != 0 ? all[f].n_views : 0));
}

TEST_CASE("GpuSurface: uniform sampling gives every face the steps that the CPU gives it") {
    const EglContext context(DeviceChoice::any);
    const PhotoImages images = make_photo_images(sphere_capture(6, 128), 3);
    const Mesh mesh = random_surfaces()[0].mesh;
    const Visibility visibility(images, mesh);
    std::vector<double> areas_px;
    for (std::int32_t f = 0; f < mesh.n_faces(); ++f) areas_px.push_back(visibility.mean_area_px(f));
    const auto expected = lattice_steps(areas_px, 2.0, Sampling::uniform);
    DeviceWork work;
    GpuSurface surface(images);
    surface.set(mesh, 0, 2.0, {}, Sampling::uniform, work);
    const auto faces = surface.read_faces(work);
    for (std::size_t f = 0; f < faces.size(); ++f) CHECK(faces[f].steps == expected[f]);
}
