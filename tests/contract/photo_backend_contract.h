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

/// A surface near the truth, in eight views.
struct ContractScene {
    PhotoImages images = make_photo_images(sphere_capture(8, 128), 3);
    Mesh mesh = icosphere(3, 0.99);
    std::vector<TriangleQuery> batch = whole_surface(mesh);
    std::vector<std::array<Vec3, 3>> directions = corner_normals(mesh);
};

/// terms() and distortions() speak of the same samples, at every level.
/// @param tolerance relative, of sums that may be taken in another order
inline void check_terms_and_distortions(PhotoBackend& backend, const ContractScene& scene, double tolerance) {
    REQUIRE(backend.n_levels() == scene.images.n_levels());
    for (int level = 0; level < backend.n_levels(); ++level) {
        backend.set_surface(scene.mesh, level, 1.0);
        const auto distortions = backend.distortions(scene.batch);
        const auto terms = backend.terms(scene.batch, scene.directions);
        REQUIRE(distortions.size() == scene.batch.size());
        REQUIRE(terms.size() == scene.batch.size());
        double n_samples = 0;
        for (std::size_t f = 0; f < scene.batch.size(); ++f) {
            CHECK(terms[f].distortion.n_samples == doctest::Approx(distortions[f].n_samples).epsilon(tolerance));
            CHECK(terms[f].distortion.phi == doctest::Approx(distortions[f].phi).epsilon(1e-3));
            CHECK(distortions[f].phi >= 0);
            for (double h : terms[f].middle_hessian) CHECK(h >= 0);
            for (std::size_t k = 0; k < 3; ++k) CHECK(terms[f].hessian[k] >= 0);
            CHECK(backend.pixel_size(static_cast<std::int32_t>(f)) > 0);
            n_samples += distortions[f].n_samples;
        }
        CHECK(n_samples > 0);
    }
}

/// A part of a batch, in another order, gives the same answers: queries know nothing of each other.
inline void check_parts_of_batches(PhotoBackend& backend, const ContractScene& scene, double tolerance) {
    backend.set_surface(scene.mesh, 0, 1.0);
    const auto whole = backend.distortions(scene.batch);
    std::vector<TriangleQuery> part;
    for (std::size_t f = scene.batch.size(); f-- > 0;)
        if (f % 3 == 0) part.push_back(scene.batch[f]);
    const auto partial = backend.distortions(part);
    for (std::size_t i = 0; i < part.size(); ++i) {
        const TriangleDistortion& expected = whole[static_cast<std::size_t>(part[i].face)];
        CHECK(partial[i].phi == doctest::Approx(expected.phi).epsilon(tolerance));
        CHECK(partial[i].n_samples == doctest::Approx(expected.n_samples).epsilon(tolerance));
    }
    CHECK(backend.distortions({}).empty());
}

/// Twice the samples per pixel: about twice the samples, about the same mean.
inline void check_density(PhotoBackend& backend, const ContractScene& scene) {
    const auto sampled = [&](double samples_per_px) {
        backend.set_surface(scene.mesh, 0, samples_per_px);
        return backend.distortions(scene.batch);
    };
    const auto n_samples = [](const std::vector<TriangleDistortion>& all) {
        double n = 0;
        for (const TriangleDistortion& d : all) n += d.n_samples;
        return n;
    };
    const auto once = sampled(1.0), twice = sampled(2.0);
    CHECK(n_samples(twice) / n_samples(once) == doctest::Approx(2.0).epsilon(0.2));
    CHECK(surface_distortion(twice) == doctest::Approx(surface_distortion(once)).epsilon(0.15));
}

/// Any number of threads gives the same bytes.
inline void check_threads(PhotoBackend& backend, const ContractScene& scene) {
    const auto on_threads = [&](std::size_t n_threads) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, n_threads);
        backend.set_surface(scene.mesh, 0, 1.0);
        std::vector<double> numbers;
        for (const TriangleTerms& t : backend.terms(scene.batch, scene.directions)) {
            numbers.push_back(t.distortion.phi);
            numbers.insert(numbers.end(), t.gradient.begin(), t.gradient.end());
        }
        return numbers;
    };
    CHECK(on_threads(1) == on_threads(2));
}

/// Whoever is lent the visibility sees what one of their own would show.
inline void check_lent_visibility(PhotoBackend& backend, const ContractScene& scene) {
    backend.set_surface(scene.mesh, 0, 1.0);
    const Visibility* const lent = backend.visibility();
    if (lent == nullptr) return;
    const Visibility own(scene.images, scene.mesh);
    const auto is_same = [](const FaceView& a, const FaceView& b) { return a.view == b.view && a.whole == b.whole; };
    for (std::int32_t f = 0; f < scene.mesh.n_faces(); ++f)
        CHECK(std::ranges::equal(lent->views(f), own.views(f), is_same));
}

/// @param tolerance relative, of sums that may be taken in another order
inline void check_photo_backend(const BackendFactory& make, double tolerance) {
    const ContractScene scene;
    const auto backend = make(scene.images, Sampling::adaptive);
    check_terms_and_distortions(*backend, scene, tolerance);
    check_parts_of_batches(*backend, scene, tolerance);
    check_density(*backend, scene);
    check_threads(*backend, scene);
    check_lent_visibility(*backend, scene);
}

}  // namespace anyrate
