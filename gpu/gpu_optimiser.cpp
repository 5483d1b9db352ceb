#include "gpu/gpu_optimiser.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <string>

#include "core/reconstruction/normal_displacement.h"
#include "gpu/round_structure.h"
#include "gpu/shaders.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

// As shaders/round.glsl has them.
struct DeviceControl {
    double damping = 0, energy = 0, bending = 0, first_samples = 0, credible = 0;
    double silhouette, bending_part, noisy_bending, noisy_psi, clean_psi, noise_psi, outlier, weak_evidence;
    double converged, least_curvature;
    double more_damping, less_damping, least_damping, reach_px, beyond_px;
    std::int32_t n_taken = 0, n_refused = 0, falls = 0;
    std::int32_t n_steps, most_trials, n_trial_gates = 0, n_gates = 0, is_faint = 0;
};
static_assert(sizeof(DeviceControl) == 192);
struct DeviceGate {
    std::uint32_t n_groups = 0, is_open = 0, one = 1;
};
static_assert(sizeof(DeviceGate) == 12);
constexpr std::size_t n_fields = 23, n_uploaded_fields = 2;  // of an active vertex
constexpr std::size_t n_entry_numbers = 3;                   // of a neighbour

/// Invocations that have all vertices to themselves: as many as OpenGL 4.5 promises, or where the CPU computes, one at
/// a time in any case, few.
int workers_on(const GraphicsDevice& device) { return device.is_software ? 64 : 1024; }

/// A program that goes through the vertices or faces by items.
std::string by_items(std::string_view shader) {
    return "#define MAYBE_COHERENT\n" + std::string(shaders::common) + std::string(shaders::round) +
           std::string(shader);
}

/// A program of one work group.
std::string by_one_group(std::string_view shader) {
    return "#define MAYBE_COHERENT coherent\n" + std::string(shaders::round) + std::string(shaders::workgroup) +
           std::string(shader);
}

std::string defines(const GraphicsDevice& device, bool is_first = false) {
    return "#define WORKERS " + std::to_string(workers_on(device)) + "\n#define N_TERMS " +
           std::to_string(DeviceTerms::n_terms) + "\n#define MAX_CG_ITERATIONS " + std::to_string(max_cg_iterations) +
           "\n#define CG_TOLERANCE " + std::to_string(cg_tolerance) + "\n#define IS_FIRST " + (is_first ? "1" : "0") +
           "\n";
}

DeviceControl control_of(const OptimiseRound& round, std::span<const double> pixels, double damping) {
    const RoundRules rules = round_rules();
    return {.damping = damping,
            .silhouette = round.options.silhouette,
            .bending_part = round.options.bending,
            .noisy_bending = rules.noisy_bending,
            .noisy_psi = rules.noisy_psi,
            .clean_psi = rules.clean_psi,
            .noise_psi = rules.noise_psi,
            .outlier = rules.outlier,
            .weak_evidence = rules.weak_evidence,
            .converged = rules.converged,
            .least_curvature = least_curvature(pixels),
            .more_damping = rules.more_damping,
            .less_damping = rules.less_damping,
            .least_damping = rules.least_damping,
            .reach_px = round.options.silhouette_reach_px,
            .beyond_px = Silhouettes::beyond_px,
            .n_steps = round.options.steps_per_round,
            .most_trials = rules.most_trials};
}

/// What the device is told of each active vertex: the longest step, world units, and the edge around it in pixels.
/// @param pixels  of the active vertices, world units
std::vector<double> fields_of(const OptimiseRound& round, const SurfaceView& surface, std::span<const double> pixels) {
    const RoundRules rules = round_rules();
    const std::vector<double> edges = mean_edge_lengths(surface, round.rings);
    const std::size_t n = round.active.size();
    std::vector<double> fields(n_uploaded_fields * n);
    for (std::size_t i = 0; i < n; ++i) {
        const double edge = edges[at(round.active[i])];
        fields[i] = std::min(round.options.max_step_px * pixels[i], rules.max_step_edges * edge);
        fields[n + i] = edge / pixels[i];
    }
    return fields;
}

}  // namespace

/// The programs of a round in the order in which they are started, each by whoever is given.
struct GpuOptimiser::Sequence {
    GpuOptimiser& own;
    const OptimiseRound& round;
    std::size_t n_vertices;
    const GpuSurface& surface;
    DeviceTerms& terms;
    const TermsScene& scene;

    /// What a program of the round reads and writes at the places that all of them share.
    void bind() const {
        own.head_.bind_uniform(0);
        own.structure_.bind(0);
        surface.triangles().bind(1);
        surface.mesh().vertices.bind(2);
        own.vertex_normals_.bind(3);
        own.data_.bind(4);
        own.control_.bind(5);
    }

    /// Terms of all faces and vertices where they stand.
    void look(const Dispatch& dispatch) const {
        bind();
        dispatch(own.normals_, n_vertices);
        own.queries_.bind(6);
        dispatch(own.gather_, round.faces.size());
        terms.run(own.queries_, round.faces.size(), scene, dispatch);
        bind();
        own.silhouettes_.cameras().bind(6);
        own.silhouettes_.bind_textures();
        own.contours_.set(0, static_cast<std::int32_t>(own.silhouettes_.n_views()));
        dispatch(own.contours_, round.active.size());
    }

    void judge(const GlProgram& program, const Dispatch& dispatch) const {
        bind();
        terms.results().bind(6);
        dispatch(program, 1);
    }

    void step(const Dispatch& dispatch) const {
        bind();
        terms.results().bind(6);
        own.entries_.bind(7);
        dispatch(own.assemble_, round.active.size());
        dispatch(own.solve_, 1);
        dispatch(own.move_, round.active.size());
    }

    void trial(const Dispatch& dispatch) const {
        step(dispatch);
        look(dispatch);
        judge(own.judge_, dispatch);
    }
};

GpuOptimiser::GpuOptimiser(const GraphicsDevice& device)
    : normals_("normals", by_items(shaders::normals)),
      gather_("gather", by_items(shaders::gather)),
      contours_("contours", by_items(shaders::contours)),
      assemble_("assemble", by_items(shaders::assemble), defines(device)),
      solve_("solve", by_one_group(shaders::solve), defines(device)),
      move_("move", by_items(shaders::move)),
      weigh_("weigh", by_one_group(shaders::judge), defines(device, true)),
      judge_("judge", by_one_group(shaders::judge), defines(device)) {}

RoundOutcome GpuOptimiser::run(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping,
                               GpuSurface& surface, DeviceTerms& terms, const TermsScene& scene,
                               std::span<const double> pixel_sizes, DeviceWork& work) {
    assert(!round.active.empty() && round.options.steps_per_round > 0);
    silhouettes_.set(round.silhouettes, work);
    if (round.is_first) silhouettes_.look(surface.mesh(), work);
    const std::size_t n_active = round.active.size();
    std::size_t n_neighbours = 0;
    for (const std::int32_t v : round.active) n_neighbours += round.rings.neighbours(v).size();
    const RoundStructure structure = round_structure(round, vertices.size());
    work.write<std::int32_t>(head_, structure.head);
    work.write<std::int32_t>(structure_, structure.items);
    data_.reserve(sizeof(double) * n_fields * n_active);
    const std::vector<double> pixels = pixels_around(round, [&](std::int32_t face) { return pixel_sizes[at(face)]; });
    work.write<double>(data_, fields_of(round, SurfaceView(vertices, round.triangles), pixels));
    vertex_normals_.reserve(sizeof(Vec3) * vertices.size());
    queries_.reserve(sizeof(DeviceQuery) * round.faces.size());
    entries_.reserve(sizeof(double) * n_entry_numbers * n_neighbours);

    const Sequence sequence{*this, round, vertices.size(), surface, terms, scene};
    // How many work groups each program of a trial and of the last step takes.
    DeviceControl control = control_of(round, pixels, damping);
    std::vector<DeviceGate> gates;
    const Dispatch count = [&](const GlProgram& program, std::size_t n) {
        gates.push_back({program.n_groups(n), 0, 1});
    };
    sequence.trial(count);
    control.n_trial_gates = static_cast<std::int32_t>(gates.size());
    sequence.step(count);
    control.n_gates = static_cast<std::int32_t>(gates.size());
    std::vector<std::byte> block(sizeof(DeviceControl) + gates.size() * sizeof(DeviceGate));
    std::ranges::copy(std::as_bytes(std::span(&control, 1)), block.begin());
    std::ranges::copy(std::as_bytes(std::span(gates)), block.begin() + sizeof(DeviceControl));
    work.write<std::byte>(control_, block);

    const Dispatch at_once = [&](const GlProgram& program, std::size_t n) { work.run(program, n); };
    std::size_t gate = 0;
    const Dispatch if_open = [&](const GlProgram& program, std::size_t) {
        work.run_indirect(program, control_, sizeof(DeviceControl) + gate++ * sizeof(DeviceGate));
    };
    sequence.look(at_once);
    sequence.judge(weigh_, at_once);
    for (int k = 0; k < (control.n_steps - 1) * control.most_trials; ++k) {
        gate = 0;
        sequence.trial(if_open);
    }
    gate = at(control.n_trial_gates);
    sequence.step(if_open);

    std::array<DeviceControl, 1> end{};
    work.read<DeviceControl>(control_, end);
    std::vector<Vec3> moved(vertices.size());
    work.read<Vec3>(surface.mesh().vertices, moved);
    vertices = std::move(moved);
    return {end[0].falls != 0, end[0].damping, end[0].is_faint != 0};
}

}  // namespace anyrate
