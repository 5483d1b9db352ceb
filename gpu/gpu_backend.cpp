#include "gpu/gpu_backend.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "core/error.h"
#include "core/parallel.h"
#include "core/reconstruction/visibility.h"
#include "gpu/gl_error.h"
#include "gpu/gpu_surface.h"
#include "gpu/photo_textures.h"
#include "gpu/shaders.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// As shaders/common.glsl has them.
struct DeviceQuery {
    double corners[9];
    float directions[9];
    std::int32_t face;
};
constexpr std::size_t pair_size = 92;
static_assert(sizeof(DeviceQuery) == 112);

constexpr std::size_t n_terms = 17, n_distortion_terms = 2;        // of TriangleTerms; of TriangleDistortion
constexpr std::size_t most_scratch_bytes = std::size_t{64} << 20;  // of a part of a batch, for what is not a result

/// Invocations that share a triangle: a register of floats where the CPU computes, else a warp of NVIDIA's.
int lanes_on(const GraphicsDevice& device) { return device.is_software ? 8 : 32; }

std::string defines(int lanes, bool with_derivatives) {
    return "#define LANES " + std::to_string(lanes) + "\n#define WITH_DERIVATIVES " + (with_derivatives ? "1" : "0") +
           "\n#define N_TERMS " + std::to_string(with_derivatives ? n_terms : n_distortion_terms) + "\n";
}

/// The programs that a batch goes through.
struct BatchPrograms {
    BatchPrograms(int lanes, bool with_derivatives)
        : see("see", with_common(shaders::see), defines(lanes, with_derivatives)),
          terms("terms", with_common(shaders::terms), defines(lanes, with_derivatives)),
          reduce("reduce", with_common(shaders::reduce), defines(lanes, with_derivatives)),
          n_results(with_derivatives ? n_terms : n_distortion_terms) {}

    static std::string with_common(std::string_view shader) {
        return std::string(shaders::common) + std::string(shader);
    }

    GlProgram see, terms, reduce;
    std::size_t n_results;  ///< a triangle
};

/// The lattices of all numbers of steps, one behind the other, eight floats a sample (shaders/terms.comp).
std::vector<float> lattice_block() {
    std::vector<float> block;
    for (int M = 1; M <= max_lattice_steps; ++M)
        for (const LatticeSample& s : lattice(M)) {
            block.insert(block.end(), s.b_single, s.b_single + 3);
            block.push_back(static_cast<float>(s.weight));
            block.insert(block.end(), s.middle, s.middle + 3);
            block.push_back(static_cast<float>(s.corner));
        }
    return block;
}

class OpenGlBackend final : public GpuBackend {
public:
    OpenGlBackend(std::shared_ptr<EglContext> context, const PhotoImages& images, Sampling sampling)
        : context_(current(std::move(context))),
          images_(images),
          sampling_(sampling),
          n_lanes_(static_cast<std::size_t>(lanes_on(context_->device()))),
          textures_(images, work_),
          surface_(images),
          distortion_programs_(lanes_on(context_->device()), false),
          term_programs_(lanes_on(context_->device()), true) {
        work_.write<float>(lattices_, lattice_block());
    }

    ~OpenGlBackend() override {
        try {
            context_->make_current();
        } catch (const DeviceError&) {
            // Then the context takes what it owns with it.
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
        const std::vector<float> numbers = compute(distortion_programs_, batch, {});
        std::vector<TriangleDistortion> result(batch.size());
        for (std::size_t i = 0; i < batch.size(); ++i) result[i] = distortion_of(&numbers[i * n_distortion_terms]);
        return result;
    }

    std::vector<TriangleTerms> terms(std::span<const TriangleQuery> batch,
                                     std::span<const std::array<Vec3, 3>> directions) override {
        assert(batch.size() == directions.size());
        const std::vector<float> numbers = compute(term_programs_, batch, directions);
        std::vector<TriangleTerms> result(batch.size());
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const float* from = &numbers[i * n_terms];
            result[i].distortion = distortion_of(from);
            std::copy_n(from + 2, 3, result[i].gradient.begin());
            std::copy_n(from + 5, 6, result[i].hessian.begin());
            std::copy_n(from + 11, 3, result[i].middle_gradient.begin());
            std::copy_n(from + 14, 3, result[i].middle_hessian.begin());
        }
        return result;
    }

    double pixel_size(std::int32_t face) const override { return std::ldexp(pixel_sizes_[at(face)], level_); }
    int n_levels() const override { return images_.n_levels(); }
    const DeviceWork& work() const override { return work_; }

    void finish() override {
        context_->make_current();
        glFinish();
        check_gl("glFinish");
    }

private:
    static std::shared_ptr<EglContext> current(std::shared_ptr<EglContext> context) {
        context->make_current();
        return context;
    }

    static TriangleDistortion distortion_of(const float* from) {
        return {static_cast<double>(from[0]), static_cast<double>(from[1])};
    }

    /// The results of a batch, in its order. @param directions  empty: none are needed
    std::vector<float> compute(const BatchPrograms& programs, std::span<const TriangleQuery> batch,
                               std::span<const std::array<Vec3, 3>> directions) {
        if (batch.empty()) return {};
        context_->make_current();
        work_.write<DeviceQuery>(queries_, on_device(batch, directions));
        results_.reserve(sizeof(float) * programs.n_results * batch.size());
        const std::size_t n_views = images_.views.size();
        const std::size_t lane_bytes = sizeof(float) * programs.n_results * n_lanes_;
        const std::size_t part = std::max<std::size_t>(
            1, std::min(most_scratch_bytes / (pair_size * n_views), most_scratch_bytes / lane_bytes));
        pairs_.reserve(pair_size * n_views * std::min(part, batch.size()));
        partials_.reserve(lane_bytes * std::min(part, batch.size()));
        for (std::size_t first = 0; first < batch.size(); first += part)
            compute_part(programs, first, std::min(part, batch.size() - first));
        std::vector<float> numbers(programs.n_results * batch.size());
        work_.read<float>(results_, numbers);
        return numbers;
    }

    void compute_part(const BatchPrograms& programs, std::size_t first, std::size_t n) {
        const auto n_views = static_cast<std::int32_t>(images_.views.size());
        const auto first_query = static_cast<std::int32_t>(first), n_queries = static_cast<std::int32_t>(n);
        for (const GlProgram* program : {&programs.see, &programs.terms, &programs.reduce}) {
            program->set(0, first_query);
            program->set(1, n_queries);
        }
        queries_.bind(0);
        surface_.faces().bind(1);
        surface_.sights().bind(2);
        cameras_.bind(3);
        sizes_.bind(4);
        pairs_.bind(5);
        programs.see.set(2, n_views);
        work_.run(programs.see, n * at(n_views));

        pairs_.bind(2);
        lattices_.bind(3);
        surface_.triangles().bind(4);
        surface_.corner_weights().bind(5);
        partials_.bind(6);
        surface_.depth_sizes().bind(7);
        textures_.bind(0);
        surface_.inverse_depth().bind_sampler(1);
        programs.terms.set(2, n_views);
        programs.terms.set(3, level_);
        programs.terms.set(4, std::ldexp(1.0F, level_));
        programs.terms.set(5, std::ldexp(1.0F, -surface_.depth_level()));
        work_.run(programs.terms, n * n_lanes_);

        partials_.bind(0);
        results_.bind(1);
        work_.run(programs.reduce, n * programs.n_results);
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
    std::size_t n_lanes_;
    DeviceWork work_;
    PhotoTextures textures_;
    GpuSurface surface_;
    BatchPrograms distortion_programs_, term_programs_;
    GlBuffer lattices_, cameras_, sizes_, queries_, pairs_, partials_, results_;
    std::vector<double> pixel_sizes_;
};

}  // namespace

std::unique_ptr<GpuBackend> make_gpu_backend(std::shared_ptr<EglContext> context, const PhotoImages& images,
                                             Sampling sampling) {
    return std::make_unique<OpenGlBackend>(std::move(context), images, sampling);
}

}  // namespace anyrate
