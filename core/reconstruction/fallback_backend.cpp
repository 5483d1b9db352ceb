#include "core/reconstruction/fallback_backend.h"

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/reconstruction/optimise_round.h"

namespace anyrate {
namespace {

/// A surface to be set again, with what was asked of it.
struct KeptSurface {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    int level = 0;
    double samples_per_px = 1;
    std::vector<std::int32_t> faces;

    void set_on(PhotoBackend& backend) const {
        backend.set_surface(SurfaceView(vertices, triangles), level, samples_per_px, faces);
    }
};

class FallbackBackend final : public PhotoBackend {
public:
    FallbackBackend(const BackendFactory& preferred, const PhotoImages& images, Sampling sampling,
                    DeviceFailureFn on_failure)
        : images_(images), sampling_(sampling), on_failure_(std::move(on_failure)) {
        try {
            backend_ = preferred(images, sampling);
        } catch (const DeviceError& error) {
            on_failure_(error.what());
            backend_ = make_cpu_backend(images, sampling);
            is_cpu_ = true;
        }
    }

    void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                     std::span<const std::int32_t> faces) override {
        if (is_cpu_) return backend_->set_surface(surface, level, samples_per_px, faces);
        kept_ = {{surface.vertices.begin(), surface.vertices.end()},
                 {surface.triangles.begin(), surface.triangles.end()},
                 level,
                 samples_per_px,
                 {faces.begin(), faces.end()}};
        try {
            backend_->set_surface(surface, level, samples_per_px, faces);
        } catch (const DeviceError& error) {
            take_over(error);
        }
    }

    std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
        return answer([&] { return backend_->distortions(batch); });
    }

    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>> directions) override {
        return answer([&] { return backend_->terms(batch, directions); });
    }

    RoundOutcome optimise_round(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping) override {
        if (is_cpu_) return backend_->optimise_round(round, vertices, damping);
        kept_ = {vertices,
                 {round.triangles.begin(), round.triangles.end()},
                 round.options.level,
                 round.options.samples_per_px,
                 {round.around.begin(), round.around.end()}};
        if (round.is_first) looked_at_ = vertices;
        try {
            return backend_->optimise_round(round, vertices, damping);
        } catch (const DeviceError& error) {
            vertices = kept_.vertices;
            // What the silhouettes saw may have been on the device alone.
            round.silhouettes.look(SurfaceView(looked_at_, round.triangles));
            take_over(error);
        }
        return backend_->optimise_round(round, vertices, damping);
    }

    double pixel_size(std::int32_t face) const override { return backend_->pixel_size(face); }
    int n_levels() const override { return backend_->n_levels(); }
    /// A device's would go with it when it fails, which may be in the middle of what needs it.
    const Visibility* visibility() const override { return is_cpu_ ? backend_->visibility() : nullptr; }

private:
    template <class Ask>
    std::invoke_result_t<Ask> answer(const Ask& ask) {
        if (is_cpu_) return ask();
        try {
            return ask();
        } catch (const DeviceError& error) {
            take_over(error);
        }
        return ask();
    }

    void take_over(const DeviceError& error) {
        on_failure_(error.what());
        backend_.reset();
        backend_ = make_cpu_backend(images_, sampling_);
        is_cpu_ = true;
        kept_.set_on(*backend_);
        kept_ = {};
        looked_at_ = {};
    }

    const PhotoImages& images_;
    Sampling sampling_;
    DeviceFailureFn on_failure_;
    std::unique_ptr<PhotoBackend> backend_;
    bool is_cpu_ = false;
    KeptSurface kept_;             // while a device is asked
    std::vector<Vec3> looked_at_;  // by the silhouettes of the last optimise_surface()
};

}  // namespace

BackendFactory with_cpu_fallback(BackendFactory preferred, DeviceFailureFn on_failure) {
    return [preferred = std::move(preferred), on_failure = std::move(on_failure)](const PhotoImages& images,
                                                                                  Sampling sampling) {
        return std::unique_ptr<PhotoBackend>(
            std::make_unique<FallbackBackend>(preferred, images, sampling, on_failure));
    };
}

}  // namespace anyrate
