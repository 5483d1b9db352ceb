#pragma once
// What every PhotoBackend must keep (core/reconstruction/photo_backend.h). A backend's test calls check_photo_backend()
// with its own factory.
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/visibility.h"
#include "core/simulation/parametric_meshes.h"
#include "tests/scenes.h"

namespace anyrate {

/// @param tolerance relative, of sums that may be taken in another order
inline void check_photo_backend(const BackendFactory& make, double tolerance) {
    const Capture capture = sphere_capture(8, 128);
    const PhotoImages images = make_photo_images(capture, 3);
    const Mesh mesh = icosphere(3, 0.99);
    const auto batch = whole_surface(mesh);
    const auto directions = corner_normals(mesh);
    const auto backend = make(images, Sampling::adaptive);
    REQUIRE(backend->n_levels() == images.n_levels());

    for (int level = 0; level < backend->n_levels(); ++level) {
        backend->set_surface(mesh, level, 1.0);
        const auto distortions = backend->distortions(batch);
        const auto terms = backend->terms(batch, directions);
        REQUIRE(distortions.size() == batch.size());
        REQUIRE(terms.size() == batch.size());
        double n_samples = 0;
        for (std::size_t f = 0; f < batch.size(); ++f) {
            // terms() and distortions() speak of the same samples.
            CHECK(terms[f].distortion.n_samples == doctest::Approx(distortions[f].n_samples).epsilon(tolerance));
            CHECK(terms[f].distortion.phi == doctest::Approx(distortions[f].phi).epsilon(1e-3));
            CHECK(distortions[f].phi >= 0);
            for (double h : terms[f].middle_hessian) CHECK(h >= 0);
            for (std::size_t k = 0; k < 3; ++k) CHECK(terms[f].hessian[k] >= 0);
            CHECK(backend->pixel_size(static_cast<std::int32_t>(f)) > 0);
            n_samples += distortions[f].n_samples;
        }
        CHECK(n_samples > 0);
    }

    backend->set_surface(mesh, 0, 1.0);
    const auto whole = backend->distortions(batch);
    // A part of a batch, in another order, gives the same answers: queries know nothing of each other.
    std::vector<TriangleQuery> part;
    for (std::size_t f = batch.size(); f-- > 0;)
        if (f % 3 == 0) part.push_back(batch[f]);
    const auto partial = backend->distortions(part);
    for (std::size_t i = 0; i < part.size(); ++i) {
        const TriangleDistortion& expected = whole[static_cast<std::size_t>(part[i].face)];
        CHECK(partial[i].phi == doctest::Approx(expected.phi).epsilon(tolerance));
        CHECK(partial[i].n_samples == doctest::Approx(expected.n_samples).epsilon(tolerance));
    }

    // Twice the samples per pixel: about twice the samples, about the same mean.
    backend->set_surface(mesh, 0, 2.0);
    const auto dense = backend->distortions(batch);
    double n_whole = 0, n_dense = 0;
    for (std::size_t f = 0; f < batch.size(); ++f) {
        n_whole += whole[f].n_samples;
        n_dense += dense[f].n_samples;
    }
    CHECK(n_dense / n_whole == doctest::Approx(2.0).epsilon(0.2));
    CHECK(surface_distortion(dense) == doctest::Approx(surface_distortion(whole)).epsilon(0.15));

    // Any number of threads gives the same bytes.
    const auto on_threads = [&](std::size_t n_threads) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, n_threads);
        backend->set_surface(mesh, 0, 1.0);
        std::vector<double> numbers;
        for (const TriangleTerms& t : backend->terms(batch, directions)) {
            numbers.push_back(t.distortion.phi);
            numbers.insert(numbers.end(), t.gradient.begin(), t.gradient.end());
        }
        return numbers;
    };
    CHECK(on_threads(1) == on_threads(2));

    CHECK(backend->distortions({}).empty());

    // Whoever is lent the visibility sees what one of their own would show.
    backend->set_surface(mesh, 0, 1.0);
    if (const Visibility* const lent = backend->visibility()) {
        const Visibility own(images, mesh);
        const auto is_same = [](const FaceView& a, const FaceView& b) {
            return a.view == b.view && a.whole == b.whole;
        };
        for (std::int32_t f = 0; f < mesh.n_faces(); ++f)
            CHECK(std::ranges::equal(lent->views(f), own.views(f), is_same));
    }
}

}  // namespace anyrate
