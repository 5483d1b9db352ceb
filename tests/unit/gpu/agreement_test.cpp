// GPU against CPU, to a relative 1e-4.
#include <doctest/doctest.h>

#include <cmath>

#include "core/reconstruction/photo_backend.h"
#include "gpu/egl_context.h"
#include "gpu/gpu_backend.h"
#include "tests/scenes.h"
#include "tests/unit/gpu/random_surfaces.h"

using namespace anyrate;

namespace {

constexpr double tolerance = 1e-4;

/// By Cauchy and Schwarz a derivative of phi is at most sqrt(2 phi h), h the Gauss-Newton part of the second one: what
/// its error is relative to, since its own terms cancel.
double largest_gradient(double phi, double hessian) { return std::sqrt(2 * phi * hessian); }

bool is_near(double value, double expected, double scale) {
    return std::abs(value - expected) <= tolerance * scale + 1e-6;
}

void check_terms(const TriangleTerms& gpu, const TriangleTerms& cpu) {
    CHECK(gpu.distortion.n_samples == doctest::Approx(cpu.distortion.n_samples).epsilon(tolerance));
    CHECK(is_near(gpu.distortion.phi, cpu.distortion.phi, cpu.distortion.phi));
    for (std::size_t k = 0; k < 3; ++k) {
        CAPTURE(k);
        const std::size_t next = (k + 1) % 3;
        CHECK(is_near(gpu.hessian[k], cpu.hessian[k], cpu.hessian[k]));
        CHECK(is_near(gpu.hessian[3 + k], cpu.hessian[3 + k], std::sqrt(cpu.hessian[k] * cpu.hessian[next])));
        CHECK(is_near(gpu.middle_hessian[k], cpu.middle_hessian[k], cpu.middle_hessian[k]));
        CHECK(is_near(gpu.gradient[k], cpu.gradient[k], largest_gradient(cpu.distortion.phi, cpu.hessian[k])));
        CHECK(is_near(gpu.middle_gradient[k], cpu.middle_gradient[k],
                      largest_gradient(cpu.distortion.phi, cpu.middle_hessian[k])));
    }
}

}  // namespace

TEST_CASE("GpuBackend: phi, samples and derivatives are the CPU's to a relative 1e-4, on random surfaces") {
    const PhotoImages images = make_photo_images(sphere_capture(9, 200), 4);
    const auto cpu = make_cpu_backend(images);
    const auto gpu = make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images);
    double n_samples = 0;
    for (const RandomSurface& random : random_surfaces()) {
        CAPTURE(random.name);
        const auto batch = whole_surface(random.mesh);
        const auto directions = corner_normals(random.mesh);
        for (int level = 0; level < images.n_levels(); ++level) {
            CAPTURE(level);
            cpu->set_surface(random.mesh, level, 1.5);
            gpu->set_surface(random.mesh, level, 1.5);
            const auto expected = cpu->terms(batch, directions), got = gpu->terms(batch, directions);
            const auto distortions = gpu->distortions(batch);
            for (std::size_t f = 0; f < batch.size(); ++f) {
                CAPTURE(f);
                check_terms(got[f], expected[f]);
                CHECK(distortions[f].phi == doctest::Approx(expected[f].distortion.phi).epsilon(tolerance));
                CHECK(gpu->pixel_size(batch[f].face) == doctest::Approx(cpu->pixel_size(batch[f].face)).epsilon(1e-12));
                n_samples += expected[f].distortion.n_samples;
            }
        }
    }
    CHECK(n_samples > 10'000);
}

TEST_CASE("GpuBackend: triangles that have moved since the surface was set are the CPU's too") {
    const PhotoImages images = make_photo_images(sphere_capture(8, 160), 3);
    const Mesh mesh = random_surfaces()[0].mesh;
    const auto cpu = make_cpu_backend(images);
    const auto gpu = make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images);
    auto batch = whole_surface(mesh);
    const auto directions = corner_normals(mesh);
    for (std::size_t f = 0; f < batch.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) batch[f].corners[k] += 0.01 * directions[f][k];
    cpu->set_surface(mesh, 0, 1.0);
    gpu->set_surface(mesh, 0, 1.0);
    const auto expected = cpu->terms(batch, directions), got = gpu->terms(batch, directions);
    for (std::size_t f = 0; f < batch.size(); ++f) {
        CAPTURE(f);
        check_terms(got[f], expected[f]);
    }
}

TEST_CASE("GpuBackend: a camera that moves counts from the next surface on") {
    PhotoImages images = make_photo_images(sphere_capture(8, 160), 3);
    const Mesh mesh = icosphere(2, 0.98);
    const auto gpu = make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images);
    const double before = measure_surface(*gpu, mesh);
    Mat3 shift = Mat3::Identity();
    shift(0, 2) = 3;
    images.views[0].levels[0].P = shift * images.views[0].levels[0].P;
    const double after = measure_surface(*gpu, mesh);
    CHECK(after != before);
    CHECK(after == doctest::Approx(measure_surface(*make_cpu_backend(images), mesh)).epsilon(tolerance));
}

TEST_CASE("GpuBackend: views may have images of different sizes, odd ones too") {
    Capture capture = sphere_capture(8, 160);
    for (std::size_t i = 0; i < capture.views.size(); i += 2) {
        View& view = capture.views[i];
        const int width = view.image.width - 13, height = view.image.height - 7;
        ColourImage image(width, height);
        MaskImage mask(width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                image(x, y) = view.image(x, y);
                mask(x, y) = view.mask(x, y);
            }
        view.image = std::move(image);
        view.mask = std::move(mask);
    }
    const PhotoImages images = make_photo_images(capture, 4);
    const auto cpu = make_cpu_backend(images);
    const auto gpu = make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images);
    const Mesh mesh = icosphere(2, 0.98);
    const auto batch = whole_surface(mesh);
    for (int level = 0; level < images.n_levels(); ++level) {
        cpu->set_surface(mesh, level, 1.0);
        gpu->set_surface(mesh, level, 1.0);
        CHECK(surface_distortion(gpu->distortions(batch)) ==
              doctest::Approx(surface_distortion(cpu->distortions(batch))).epsilon(tolerance));
    }
}

TEST_CASE("GpuBackend: the same question gets the same bytes") {
    const PhotoImages images = make_photo_images(sphere_capture(8, 160), 3);
    const Mesh mesh = random_surfaces()[1].mesh;
    const auto gpu = make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images);
    const auto ask = [&] {
        gpu->set_surface(mesh, 1, 1.0);
        std::vector<double> numbers;
        for (const TriangleTerms& t : gpu->terms(whole_surface(mesh), corner_normals(mesh))) {
            numbers.push_back(t.distortion.phi);
            numbers.insert(numbers.end(), t.gradient.begin(), t.gradient.end());
            numbers.insert(numbers.end(), t.middle_hessian.begin(), t.middle_hessian.end());
        }
        return numbers;
    };
    CHECK(ask() == ask());
}
