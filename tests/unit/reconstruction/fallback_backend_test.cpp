#include "core/reconstruction/fallback_backend.h"

#include <doctest/doctest.h>

#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/reconstruction/optimise_round.h"
#include "core/reconstruction/reconstruct.h"
#include "tests/scenes.h"

using namespace anyrate;

namespace {

/// The CPU's answers, until the call after the first `n_calls`.
class FailingBackend final : public PhotoBackend {
public:
    FailingBackend(const PhotoImages& images, Sampling sampling, int n_calls)
        : cpu_(make_cpu_backend(images, sampling)), n_left_(n_calls) {}

    void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                     std::span<const std::int32_t> faces) override {
        count();
        cpu_->set_surface(surface, level, samples_per_px, faces);
    }
    std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
        count();
        return cpu_->distortions(batch);
    }
    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>> directions) override {
        count();
        return cpu_->terms(batch, directions);
    }
    double pixel_size(std::int32_t face) const override { return cpu_->pixel_size(face); }
    int n_levels() const override { return cpu_->n_levels(); }

private:
    void count() {
        if (n_left_-- <= 0) throw DeviceError("the device is out of memory");
    }

    std::unique_ptr<PhotoBackend> cpu_;
    int n_left_;
};

BackendFactory failing_after(int n_calls) {
    return [n_calls](const PhotoImages& images, Sampling sampling) {
        return std::make_unique<FailingBackend>(images, sampling, n_calls);
    };
}

/// The states that a sink was given.
class States final : public ModelSink {
public:
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override {
        hashes.push_back(RefinableMesh(base, grid, rules).state_hash());
        return base;
    }
    void base_attributes(std::span<const Rgb8>, const DistortionPoint&) override {}
    void batch(std::span<const SplitRecord>, const RefinableMesh& state, std::span<const Rgb8>,
               const DistortionPoint&) override {
        hashes.push_back(state.state_hash());
    }
    void finish() override { is_finished = true; }

    std::vector<std::uint32_t> hashes;
    bool is_finished = false;
};

States states_of(const BackendFactory& backend) {
    States states;
    ReconstructOptions options{.n_vertices = 500, .n_coarse = 200};
    options.backend = backend;
    reconstruct(sphere_capture(8, 96), options, states);
    return states;
}

}  // namespace

TEST_CASE("FallbackBackend: a device that fails in the middle of a job leaves the model that the CPU makes") {
    const States expected = states_of(make_cpu_backend);
    REQUIRE(expected.is_finished);
    REQUIRE(expected.hashes.size() > 2);
    // While it is made, at its first surface, at the first question, in the coarse mesh and in the refinement.
    for (const int n_calls : {0, 1, 8, 17, 60}) {
        CAPTURE(n_calls);
        std::vector<std::string> warnings;
        const auto warn = [&](const std::string& reason) { warnings.push_back(reason); };
        const States states = states_of(with_cpu_fallback(failing_after(n_calls), warn));
        CHECK(states.is_finished);
        CHECK(states.hashes == expected.hashes);
        CHECK(warnings == std::vector<std::string>{"the device is out of memory"});
    }
}

TEST_CASE("FallbackBackend: a device that fails in a later round of its own leaves the surface that the CPU makes") {
    /// Looks at the silhouettes on its own, as a device does, and fails in its second round, having moved vertices.
    class FailingInRounds final : public PhotoBackend {
    public:
        explicit FailingInRounds(const PhotoImages& images) : cpu_(make_cpu_backend(images)) {}
        void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                         std::span<const std::int32_t> faces) override {
            cpu_->set_surface(surface, level, samples_per_px, faces);
        }
        std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
            return cpu_->distortions(batch);
        }
        std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                         std::span<const std::array<Vec3, 3>> directions) override {
            return cpu_->terms(batch, directions);
        }
        RoundOutcome optimise_round(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping) override {
            if (round.is_first) own_ = round.silhouettes;
            const OptimiseRound on_device{round.triangles, round.rings,   round.active, round.around,
                                          round.faces,     round.options, *own_,        round.is_first};
            const RoundOutcome outcome = cpu_->optimise_round(on_device, vertices, damping);
            if (!round.is_first) throw DeviceError("the context is lost");
            return outcome;
        }
        double pixel_size(std::int32_t face) const override { return cpu_->pixel_size(face); }
        int n_levels() const override { return cpu_->n_levels(); }

    private:
        std::unique_ptr<PhotoBackend> cpu_;
        std::optional<Silhouettes> own_;
    };
    const Capture capture = sphere_capture(8, 128);
    const PhotoImages images = make_photo_images(capture, 3);
    int n_warnings = 0;
    const auto optimised = [&](PhotoBackend& backend) {
        Silhouettes silhouettes(capture);
        Mesh mesh = icosphere(3, 0.96);
        optimise_surface(backend, silhouettes, mesh.vertices, mesh.triangles, {}, {}, {});
        return mesh.vertices;
    };
    const BackendFactory failing = [](const PhotoImages& of, Sampling) {
        return std::make_unique<FailingInRounds>(of);
    };
    const auto backend = with_cpu_fallback(failing, [&](const std::string&) { ++n_warnings; })(images, {});
    CHECK(optimised(*backend) == optimised(*make_cpu_backend(images)));
    CHECK(n_warnings == 1);
}

TEST_CASE("FallbackBackend: where no device can be had the CPU has all of the work") {
    int n_warnings = 0;
    const BackendFactory none = [](const PhotoImages&, Sampling) -> std::unique_ptr<PhotoBackend> {
        throw DeviceError("no device");
    };
    const PhotoImages images = make_photo_images(sphere_capture(6, 96), 2);
    const Mesh mesh = icosphere(2);
    const auto backend = with_cpu_fallback(none, [&](const std::string&) { ++n_warnings; })(images, Sampling::adaptive);
    CHECK(n_warnings == 1);
    CHECK(measure_surface(*backend, mesh) == measure_surface(*make_cpu_backend(images, Sampling::adaptive), mesh));
}

TEST_CASE("FallbackBackend: what is no failure of the device goes through") {
    class Broken final : public PhotoBackend {
        void set_surface(const SurfaceView&, int, double, std::span<const std::int32_t>) override {
            throw InputError("not a device's");
        }
        std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery>) override { return {}; }
        std::vector<TriangleTerms> terms(std::span<const TriangleQuery>,
                                         std::span<const std::array<Vec3, 3>>) override {
            return {};
        }
        double pixel_size(std::int32_t) const override { return 1; }
        int n_levels() const override { return 1; }
    };
    const PhotoImages images = make_photo_images(sphere_capture(6, 96), 2);
    const auto backend = with_cpu_fallback([](const PhotoImages&, Sampling) { return std::make_unique<Broken>(); },
                                           [](const std::string&) {})(images, Sampling::adaptive);
    CHECK_THROWS_AS(backend->set_surface(icosphere(1), 0, 1.0), InputError);
}
