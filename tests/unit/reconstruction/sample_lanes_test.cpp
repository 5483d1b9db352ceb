#include "core/reconstruction/sample_lanes.h"

#include <doctest/doctest.h>

#include <random>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/sampling.h"

using namespace anyrate;

namespace {

PhotoLevel image_of(int width, int height) {
    PhotoLevel image;
    image.width = width;
    image.height = height;
    image.rgba.assign(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255);
    return image;
}

PhotoLevel noise(int width, int height) {
    PhotoLevel image = image_of(width, height);
    std::mt19937 random(7);
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(random());
    return image;
}

PhotoLevel plain(int width, int height, const Vec3& colour) {
    PhotoLevel image = image_of(width, height);
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(colour[static_cast<int>(i % 4)]);
    return image;
}

/// A triangle with these corners, pixels, at depths 1, 1.5 and 2; it stands still.
TriangleView view_of(const PhotoLevel& image, const Vec2 (&corners)[3]) {
    TriangleView view;
    view.whole = true;
    view.width = static_cast<float>(image.width - 1);
    view.height = static_cast<float>(image.height - 1);
    view.pixels = image.pixel(0, 0);
    view.row = 4 * image.width;
    for (std::size_t k = 0; k < 3; ++k) {
        const float z = 1.0F + 0.5F * static_cast<float>(k);
        view.corner_x[k] = static_cast<float>(corners[k].x()) * z;
        view.corner_y[k] = static_cast<float>(corners[k].y()) * z;
        view.corner_z[k] = z;
        view.motion_x[k] = view.motion_y[k] = view.motion_z[k] = 0;
    }
    return view;
}

}  // namespace

TEST_CASE("Sample lanes: the lanes of a lattice are its samples, and what is left over weighs nothing") {
    for (int M : {1, 2, 3, 7, 13, max_lattice_steps}) {
        const auto samples = lattice(M);
        const auto groups = lattice_lanes(M);
        REQUIRE(groups.size() == (samples.size() + n_lanes - 1) / n_lanes);
        for (std::size_t i = 0; i < groups.size() * n_lanes; ++i) {
            const SampleLanes& group = groups[i / n_lanes];
            const std::size_t lane = i % n_lanes;
            const bool is_sample = i < samples.size();
            CHECK(group.weight[lane] == (is_sample ? static_cast<float>(samples[i].weight) : 0.0F));
            for (std::size_t k = 0; k < 3; ++k) {
                const bool is_corner = is_sample && samples[i].corner == static_cast<int>(k);
                CHECK(group.is_corner[k][lane] == (is_corner ? 1.0F : 0.0F));
                if (is_sample) CHECK(group.b[k][lane] == samples[i].b_single[k]);
            }
        }
    }
}

TEST_CASE(
    "Sample lanes: colours and derivatives are those of sample_colour, and nothing is seen where it sees nothing") {
    PhotoLevel image = noise(24, 18);
    for (int y = 5; y < 9; ++y)
        for (int x = 10; x < 13; ++x)
            image.rgba[4 * (static_cast<std::size_t>(y) * 24 + static_cast<std::size_t>(x)) + 3] = 0;  // no object
    const Vec2 corners[3] = {{-3.317, 2.213}, {27.139, 1.427}, {11.731, 20.911}};  // over three borders
    const TriangleView view = view_of(image, corners);
    int n_seen = 0, n_unseen = 0;
    for (const SampleLanes& lanes : lattice_lanes(20)) {
        LanesInView samples;
        look_at_lanes(lanes, {&view, 1}, {&samples, 1});
        for (std::size_t lane = 0; lane < n_lanes; ++lane) {
            double x = 0, y = 0, z = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto b = static_cast<double>(lanes.b[k][lane]);
                x += b * static_cast<double>(view.corner_x[k]);
                y += b * static_cast<double>(view.corner_y[k]);
                z += b * static_cast<double>(view.corner_z[k]);
            }
            ColourSample expected;
            const bool is_seen = sample_colour(image, x / z, y / z, expected);
            REQUIRE((samples.seen[lane] != 0) == is_seen);
            (is_seen ? n_seen : n_unseen)++;
            if (!is_seen) continue;
            CHECK(static_cast<double>(samples.inverse_z[lane]) == doctest::Approx(1 / z));
            for (std::size_t k = 0; k < 3; ++k) {
                CHECK(float(samples.colour[k][lane]) == doctest::Approx(expected.c[k]).epsilon(1e-3));
                CHECK(std::abs(samples.dx[k][lane] - expected.dx[k]) < 0.02F);
                CHECK(std::abs(samples.dy[k][lane] - expected.dy[k]) < 0.02F);
            }
        }
    }
    CHECK(n_seen > 100);
    CHECK(n_unseen > 20);
}

TEST_CASE("Sample lanes, Eq. 5: two plain views differ by half their squared distance, one view says nothing") {
    const Vec3 red(200, 20, 40), blue(30, 50, 220);
    const PhotoLevel images[2] = {plain(16, 16, red), plain(16, 16, blue)};
    const Vec2 corners[3] = {{2, 2}, {13, 3}, {6, 12}};
    const TriangleView views[2] = {view_of(images[0], corners), view_of(images[1], corners)};
    for (std::size_t n_views : {std::size_t{1}, std::size_t{2}}) {
        TermLanes distortion, terms;
        double weight = 0;
        for (const SampleLanes& lanes : lattice_lanes(5)) {
            LanesInView samples[2];
            look_at_lanes(lanes, {views, n_views}, {samples, n_views});
            add_distortion(lanes.weight, {samples, n_views}, distortion);
            add_terms(lanes, lanes.weight, {views, n_views}, {samples, n_views}, terms);
            weight += sum_of_lanes(lanes.weight);
        }
        const double n_samples = n_views == 2 ? weight : 0;
        CHECK(sum_of_lanes(distortion.n_samples) == doctest::Approx(n_samples));
        CHECK(sum_of_lanes(distortion.phi) == doctest::Approx(n_samples * 0.5 * (red - blue).squaredNorm()));
        CHECK(sum_of_lanes(terms.phi) == doctest::Approx(sum_of_lanes(distortion.phi)));
        for (const Float8& gradient : terms.gradient) CHECK(sum_of_lanes(gradient) == 0);
    }
}
