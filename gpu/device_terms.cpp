#include "gpu/device_terms.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "gpu/shaders.h"

namespace anyrate {
namespace {

constexpr std::size_t pair_size = 92;                              // of shaders/common.glsl
constexpr std::size_t most_scratch_bytes = std::size_t{64} << 20;  // of a part of a batch, for what is not a result

/// Invocations that share a triangle: a register of floats where the CPU computes, else a warp of NVIDIA's.
std::size_t lanes_on(const GraphicsDevice& device) { return device.is_software ? 8 : 32; }

std::string defines(std::size_t lanes, bool with_derivatives, std::size_t n_results) {
    return "#define LANES " + std::to_string(lanes) + "\n#define WITH_DERIVATIVES " + (with_derivatives ? "1" : "0") +
           "\n#define N_TERMS " + std::to_string(n_results) + "\n";
}

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

}  // namespace

DeviceTerms::DeviceTerms(const GraphicsDevice& device, bool with_derivatives, DeviceWork& work)
    : n_lanes_(lanes_on(device)),
      n_results_(with_derivatives ? n_terms : n_distortion_terms),
      see_("see", shaders::with_common(shaders::see), defines(n_lanes_, with_derivatives, n_results_)),
      terms_("terms", shaders::with_common(shaders::terms), defines(n_lanes_, with_derivatives, n_results_)),
      reduce_("reduce", shaders::with_common(shaders::reduce), defines(n_lanes_, with_derivatives, n_results_)) {
    work.write<float>(lattices_, lattice_block());
}

void DeviceTerms::run(const GlBuffer& queries, std::size_t n, const TermsScene& scene, const Dispatch& dispatch) {
    const std::size_t lane_bytes = sizeof(float) * n_results_ * n_lanes_;
    const std::size_t part = std::max<std::size_t>(
        1, std::min(most_scratch_bytes / (pair_size * scene.n_views), most_scratch_bytes / lane_bytes));
    results_.reserve(sizeof(float) * n_results_ * n);
    pairs_.reserve(pair_size * scene.n_views * std::min(part, n));
    partials_.reserve(lane_bytes * std::min(part, n));
    for (std::size_t first = 0; first < n; first += part)
        run_part(queries, first, std::min(part, n - first), scene, dispatch);
}

void DeviceTerms::run_part(const GlBuffer& queries, std::size_t first, std::size_t n, const TermsScene& scene,
                           const Dispatch& dispatch) {
    const auto n_views = static_cast<std::int32_t>(scene.n_views);
    for (const GlProgram* program : {&see_, &terms_, &reduce_}) {
        program->set(0, static_cast<std::int32_t>(first));
        program->set(1, static_cast<std::int32_t>(n));
    }
    queries.bind(0);
    scene.surface.faces().bind(1);
    scene.surface.sights().bind(2);
    scene.cameras.bind(3);
    scene.sizes.bind(4);
    pairs_.bind(5);
    see_.set(2, n_views);
    dispatch(see_, n * scene.n_views);

    pairs_.bind(2);
    lattices_.bind(3);
    scene.surface.triangles().bind(4);
    scene.surface.corner_weights().bind(5);
    partials_.bind(6);
    scene.surface.depth_sizes().bind(7);
    scene.photographs.bind(0);
    scene.surface.inverse_depth().bind_sampler(1);
    terms_.set(2, n_views);
    terms_.set(3, scene.level);
    terms_.set(4, std::ldexp(1.0F, scene.level));
    terms_.set(5, std::ldexp(1.0F, -scene.surface.depth_level()));
    dispatch(terms_, n * n_lanes_);

    partials_.bind(0);
    results_.bind(1);
    dispatch(reduce_, n * n_results_);
}

}  // namespace anyrate
