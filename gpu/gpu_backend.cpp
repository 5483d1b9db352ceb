#include "gpu/gpu_backend.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "core/reconstruction/visibility.h"
#include "gpu/device_terms.h"
#include "gpu/gl_error.h"
#include "gpu/gpu_optimiser.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

class OpenGlBackend final : public GpuBackend {
public:
    OpenGlBackend(std::shared_ptr<EglContext> context, const PhotoImages& images, Sampling sampling)
        : context_(current(std::move(context))),
          images_(images),
          sampling_(sampling),
          photographs_(images, work_),
          surface_(images),
          distortions_(context_->device(), false, work_),
          terms_(context_->device(), true, work_) {}

    ~OpenGlBackend() override {
        try {
            context_->make_current();
        } catch (const DeviceError&) {
            // Then the context takes what it owns with it, and none of its names may be deleted in another's.
            EglContext::make_none_current();
        }
    }

    void set_surface(const SurfaceView& surface, int level, double samples_per_px,
                     std::span<const std::int32_t> faces) override {
        assert(level >= 0 && level < images_.n_levels());
        context_->make_current();
        level_ = level;
        surface_.set(surface, level, samples_per_px, faces, sampling_, work_);
        work_.write<double>(cameras_, camera_block(images_, level, std::vector<double>(images_.views.size())));
        work_.write<std::int32_t>(sizes_, size_block(images_, level));
        pixel_sizes_.assign(surface.triangles.size(), 0.0);
        const std::size_t n = faces.empty() ? surface.triangles.size() : faces.size();
        parallel_for(n, [&](std::size_t i) {
            const std::size_t f = faces.empty() ? i : at(faces[i]);
            const Triangle& t = surface.triangles[f];
            const Vec3 sum = surface.vertices[at(t[0])] + surface.vertices[at(t[1])] + surface.vertices[at(t[2])];
            pixel_sizes_[f] = pixel_size_at(images_, sum / 3.0);
        });
    }

    std::vector<TriangleDistortion> distortions(std::span<const TriangleQuery> batch) override {
        const std::vector<float> numbers = compute(distortions_, batch, {});
        std::vector<TriangleDistortion> result(batch.size());
        for (std::size_t i = 0; i < batch.size(); ++i)
            result[i] = distortion_of(&numbers[i * DeviceTerms::n_distortion_terms]);
        return result;
    }

    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>> directions) override {
        assert(batch.size() == directions.size());
        const std::vector<float> numbers = compute(terms_, batch, directions);
        std::vector<TriangleTerms> result(batch.size());
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const float* from = &numbers[i * DeviceTerms::n_terms];
            result[i].distortion = distortion_of(from);
            std::copy_n(from + 2, 3, result[i].gradient.begin());
            std::copy_n(from + 5, 6, result[i].hessian.begin());
            std::copy_n(from + 11, 3, result[i].middle_gradient.begin());
            std::copy_n(from + 14, 3, result[i].middle_hessian.begin());
        }
        return result;
    }

    RoundOutcome optimise_round(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping) override {
        const OptimiseOptions& options = round.options;
        set_surface(SurfaceView(vertices, round.triangles), options.level, options.samples_per_px, round.around);
        if (round.active.empty() || options.steps_per_round < 1) return {false, damping};
        if (!optimiser_) optimiser_.emplace(context_->device());
        std::vector<double> pixel_sizes(pixel_sizes_);
        for (double& size : pixel_sizes) size = std::ldexp(size, level_);
        return optimiser_->run(round, vertices, damping, surface_, terms_, scene(), pixel_sizes, work_);
    }

    double pixel_size(std::int32_t face) const override { return std::ldexp(pixel_sizes_[at(face)], level_); }
    int n_levels() const override { return images_.n_levels(); }
    const DeviceWork& work() const override { return work_; }

    void finish() override {
        context_->make_current();
        glFinish();
        check_gl_and_reset("glFinish");
    }

private:
    static std::shared_ptr<EglContext> current(std::shared_ptr<EglContext> context) {
        context->make_current();
        return context;
    }

    static TriangleDistortion distortion_of(const float* from) {
        return {static_cast<double>(from[0]), static_cast<double>(from[1])};
    }

    TermsScene scene() const { return {surface_, photographs_, cameras_, sizes_, images_.views.size(), level_}; }

    /// The results of a batch, in its order. @param directions  empty: none are needed
    std::vector<float> compute(DeviceTerms& terms, std::span<const TriangleQuery> batch,
                               std::span<const std::array<Vec3, 3>> directions) {
        if (batch.empty()) return {};
        context_->make_current();
        work_.write<DeviceQuery>(queries_, on_device(batch, directions));
        terms.run(queries_, batch.size(), scene(),
                  [&](const GlProgram& program, std::size_t n) { work_.run(program, n); });
        std::vector<float> numbers(terms.n_results() * batch.size());
        work_.read<float>(terms.results(), numbers);
        return numbers;
    }

    static std::vector<DeviceQuery> on_device(std::span<const TriangleQuery> batch,
                                              std::span<const std::array<Vec3, 3>> directions) {
        std::vector<DeviceQuery> queries(batch.size(), DeviceQuery{});
        parallel_for(batch.size(), [&](std::size_t i) {
            queries[i].face = batch[i].face;
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const auto row = static_cast<Eigen::Index>(axis);
                    queries[i].corners[3 * k + axis] = batch[i].corners[k](row);
                    if (!directions.empty())
                        queries[i].directions[3 * k + axis] = static_cast<float>(directions[i][k](row));
                }
        });
        return queries;
    }

    std::shared_ptr<EglContext> context_;
    const PhotoImages& images_;
    Sampling sampling_;
    int level_ = 0;
    DeviceWork work_;
    PhotoTextures photographs_;
    GpuSurface surface_;
    DeviceTerms distortions_, terms_;
    std::optional<GpuOptimiser> optimiser_;
    GlBuffer cameras_, sizes_, queries_;
    std::vector<double> pixel_sizes_;
};

}  // namespace

std::unique_ptr<GpuBackend> make_gpu_backend(std::shared_ptr<EglContext> context, const PhotoImages& images,
                                             Sampling sampling) {
    return std::make_unique<OpenGlBackend>(std::move(context), images, sampling);
}

}  // namespace anyrate
