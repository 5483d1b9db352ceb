#include "core/reconstruction/robust_terms.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace anyrate;

namespace {

/// A face whose n samples have the mean distortion a + b u + c u^2 where its first corner is moved by u.
TriangleTerms quadratic_face(double n, double a, double b, double c, double u) {
    TriangleTerms t;
    t.distortion = {n * (a + b * u + c * u * u), n};
    t.gradient[0] = n * (b + 2 * c * u);
    t.hessian[0] = n * 2 * c;
    return t;
}

TriangleTerms robust(TriangleTerms t, double credible) {
    make_robust({&t, 1}, credible);
    return t;
}

}  // namespace

TEST_CASE("Robust terms: the gradient is the derivative of phi") {
    constexpr double h = 1e-5;
    for (const double credible : {0.5, 10.0, 1000.0}) {
        const auto phi = [&](double u) { return robust(quadratic_face(7, 9, -4, 2, u), credible).distortion.phi; };
        for (const double u : {-1.0, 0.3, 5.0}) {
            CAPTURE(credible);
            CAPTURE(u);
            const double expected = (phi(u + h) - phi(u - h)) / (2 * h);
            CHECK(robust(quadratic_face(7, 9, -4, 2, u), credible).gradient[0] ==
                  doctest::Approx(expected).epsilon(1e-6));
        }
    }
}

TEST_CASE("Robust terms: what is credible stays about as it is, what is not counts by its logarithm") {
    const TriangleTerms small = quadratic_face(20, 1, 0.1, 0.3, 0), kept = robust(small, 1e4);
    CHECK(kept.distortion.phi == doctest::Approx(small.distortion.phi).epsilon(1e-4));
    CHECK(kept.hessian[0] == doctest::Approx(small.hessian[0]).epsilon(2e-4));
    CHECK(kept.distortion.n_samples == 20);
    // phi = n T log(1 + G / T): ten times the distortion far beyond T adds n T log(10).
    const double once = robust(quadratic_face(20, 1e6, 0, 0, 0), 1).distortion.phi;
    const double ten_times = robust(quadratic_face(20, 1e7, 0, 0, 0), 1).distortion.phi;
    CHECK(ten_times - once == doctest::Approx(20 * std::log(10.0)).epsilon(1e-5));
}

TEST_CASE(
    "Robust terms: the credible distortion is a multiple of the samples' geometric mean, and none below the noise") {
    std::vector<TriangleTerms> terms{quadratic_face(10, 4, 0, 0, 0), quadratic_face(10, 16, 0, 0, 0), TriangleTerms()};
    CHECK(credible_distortion(terms, 2, 30) == doctest::Approx(30 * 8));
    terms[0] = quadratic_face(30, 4, 0, 0, 0);
    CHECK(credible_distortion(terms, 2, 30) == doctest::Approx(30 * std::pow(4.0, 0.75) * std::pow(16.0, 0.25)));
    terms[0] = quadratic_face(10, 0, 0, 0, 0);
    CHECK(credible_distortion(terms, 4, 1) == doctest::Approx(8));
}

TEST_CASE("Robust terms: faces without samples say nothing, and if none has any, all stays as it is") {
    std::vector<TriangleTerms> terms(3);
    const double credible = credible_distortion(terms, 2, 30);
    CHECK(std::isinf(credible));
    make_robust(terms, credible);
    make_robust(terms, 5);
    for (const TriangleTerms& t : terms) CHECK(t.distortion.phi == 0);
}
