#include "core/reconstruction/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "core/mesh/coarse_fit.h"
#include "core/mesh/decimate.h"
#include "core/mesh/keep_apart.h"
#include "core/mesh/remesh.h"
#include "core/mesh/subdivide.h"
#include "core/parallel.h"
#include "core/progressive/base_on_grid.h"
#include "core/reconstruction/capture_frame.h"
#include "core/reconstruction/confirm_guesses.h"
#include "core/reconstruction/exposure.h"
#include "core/reconstruction/flow.h"
#include "core/reconstruction/initial_mesh.h"
#include "core/reconstruction/mask_growth.h"
#include "core/reconstruction/optimise_surface.h"
#include "core/reconstruction/pixel_footprint.h"
#include "core/reconstruction/preview.h"
#include "core/reconstruction/refine.h"
#include "core/reconstruction/state_attributes.h"
#include "core/reconstruction/untangle.h"
#include "core/reconstruction/vertex_colours.h"
#include "core/reconstruction/view_shifts.h"

namespace anyrate {
namespace {

constexpr int coarsest_level = 3;          ///< of the pyramid, where the coarse mesh starts to move
constexpr int usual_even = 4000;           ///< vertices in the even mesh, before it is subdivided
constexpr double even_density = 1.6;       ///< coarse counts of vertices there, if that is more
constexpr double least_density = 0.5;      ///< coarse counts there however few the photographs resolve
constexpr int fewest_even = 1000;          ///< vertices there: fewer may not carry the surface
constexpr double even_detail = 0.1;        ///< see RemeshOptions; 0: coarse levels lose thin parts, pot 5 % worse
constexpr double simplified_part = 0.3;    ///< of the fine surface's vertices, before it is subdivided; 0.2: 1 % worse
constexpr double fine_over_log = 1.2;      ///< vertices of the log that approaches it, if the even mesh has fewer
constexpr int log_steps = 160;             ///< an edge; with 80 errors are 4 to 6 % larger, for 7 to 10 % less bytes
constexpr int noisy_log_steps = 80;        ///< where images disagree more than the next tells: finer ones send noise
constexpr double most_credible_psi = 600;  ///< squared colour units: the Oxford dinosaur has 1,280, a pot 84
constexpr int samples_per_vertex = 10;     ///< of that surface, which stand for it when the base is fitted
constexpr double least_shift_px = 0.1;     ///< of the views, root mean square: good cameras measure less than 0.09
constexpr double least_growth_px = 0.5;    ///< of the masks: good ones measure less than 0.25
constexpr double contour_reach_px = 8.0;   ///< while contours are still on their way
constexpr int smallest_count = 100, largest_count = 1'000'000;

void check(const ReconstructOptions& options) {
    const auto require = [](bool holds, const std::string& sentence) {
        if (!holds) throw InputError(sentence);
    };
    const auto require_count = [&](const char* name, int count, int least) {
        require(count >= least && count <= largest_count,
                std::string(name) + ": expected a number from " + std::to_string(least) + " to " +
                    std::to_string(largest_count) + ", got " + std::to_string(count));
    };
    require_count("vertices", options.n_vertices, smallest_count);
    require_count("coarse", options.n_coarse, smallest_count);
    require_count("vertices, no fewer than coarse", options.n_vertices, options.n_coarse);
    require(options.samples_per_px > 0,
            "samples per pixel: expected a number above 0, got " + std::to_string(options.samples_per_px));
}

/// The first picture for who waits for one.
void send_preview(ModelSink& sink, const VisualHull& hull, const PhotoImages& images, const CaptureFrame& frame) {
    ModelSink* const preview = sink.preview();
    if (preview == nullptr) return;
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const Mesh mesh = preview_mesh(hull);
    const Grid grid = make_grid(mesh, mesh.n_vertices());
    const RefinementRules rules;
    const RefinableMesh state(preview->start(frame.in_world(grid), rules, to_base(mesh, grid)), grid, rules);
    const Mesh as_decoded = state.to_mesh();
    preview->base_attributes(vertex_colours(images, as_decoded, vertex_spacing(as_decoded, state.n_vertices())),
                             {unknown, unknown});
}

/// What step 1 leaves to the others.
struct Start {
    PhotoImages images;
    Silhouettes silhouettes;
    GuessedSurface guessed;
    Mesh mesh;
    int n_resolved = 0;                     // vertices, see resolved_vertices()
    int n_even = 0;                         // vertices of the mesh once it is optimised, before parts of it get more
    std::vector<Gains> gains;               // that the colours were divided by
    std::vector<std::vector<Vec2>> shifts;  // of the views, each time they were moved
};

/// The mesh that step 2 starts from. Only the paper's baseline moves the vertices that are asked for: the others are
/// simplified from a mesh that has no fewer the fewer are asked for, so that a small log loses nothing but vertices,
/// and none that the photographs do not resolve (n_resolved).
RemeshOptions remesh_options(const ReconstructOptions& options, int n_resolved) {
    if (options.method == Method::flow) return {.n_vertices = options.n_vertices};
    const int n_wanted = std::max(usual_even, static_cast<int>(even_density * options.n_coarse));
    const int n_resolved_by_even = n_resolved / 4;  // it is subdivided
    return {.n_vertices = std::max({std::min(n_wanted, n_resolved_by_even),
                                    static_cast<int>(least_density * options.n_coarse), fewest_even}),
            .detail = even_detail};
}

/// Step 1: hull, Poisson, remesh.
Start make_start(Capture capture, const ReconstructOptions& options, const CaptureFrame& frame, ModelSink& sink,
                 const ProgressFn& tell) {
    PhotoImages images = make_photo_images(capture);
    for (View& view : capture.views) view.image = {};  // from here on the masks will do
    tell({Stage::hull, 0, 0, 0});
    const VisualHull hull = visual_hull(capture, hull_options(images));
    send_preview(sink, hull, images, frame);
    InitialSurface initial = initial_surface(hull, images, tell);
    tell({Stage::remesh, 0, 0, 0});
    const int n_resolved = resolved_vertices(initial.mesh, images);
    Mesh mesh;
    std::optional<Silhouettes> silhouettes;
    parallel_invoke([&] { mesh = remesh_isotropic(initial.mesh, remesh_options(options, n_resolved)); },
                    [&] { silhouettes.emplace(capture); });
    std::vector<Gains> gains = even_out_exposure(images, mesh);
    return {std::move(images),
            std::move(*silhouettes),
            std::move(initial.guessed),
            std::move(mesh),
            n_resolved,
            0,
            std::move(gains),
            {}};
}

/// Step 2 of Method::flow. @return Psi before each iteration and at the end
std::vector<double> flow_at_fixed_rate(PhotoBackend& sampler, PhotoBackend& backend, const ReconstructOptions& options,
                                       Mesh& mesh, const ProgressFn& tell, const std::stop_token& stop) {
    const FlowOptions flow{.samples_per_px = options.samples_per_px};
    const bool is_measure = options.sampling == Sampling::adaptive && options.samples_per_px == 1.0;
    std::vector<double> iterations;
    surface_flow(
        sampler, mesh.vertices, mesh.triangles, flow,
        [&](int i, double flow_psi) {
            iterations.push_back(is_measure ? flow_psi : measure_surface(backend, mesh));
            tell({Stage::optimise, static_cast<double>(i) / flow.max_iterations, mesh.n_vertices(), iterations.back()});
        },
        stop);
    return iterations;
}

/// Moves the views to where they show the surface, if they are off by `least_px` pixels (root mean square) or more.
/// @return whether they were
bool align_views(Start& start, int level, double least_px) {
    std::vector<Vec2> shifts = estimate_shifts(start.images, start.mesh, level);
    double squared_norm = 0;
    for (const Vec2& shift : shifts) squared_norm += shift.squaredNorm();
    if (squared_norm < least_px * least_px * static_cast<double>(shifts.size())) return false;
    std::vector<Vec3>& vertices = start.mesh.vertices;
    const Vec3 sum = std::accumulate(vertices.begin(), vertices.end(), Vec3(0, 0, 0));
    const Vec3 translation = take_translation(start.images, sum / start.mesh.n_vertices(), shifts);
    for (Vec3& v : vertices) v += translation;
    shift_views(start.images, shifts);
    start.silhouettes.shift_views(shifts);
    start.shifts.push_back(shifts);
    return true;
}

/// Moves the masks' borders to where the surface has its contours, if they are off by `least_growth_px` or more.
void align_masks(Start& start) {
    Silhouettes& silhouettes = start.silhouettes;
    const double growth = estimate_mask_growth(silhouettes, start.mesh, contour_reach_px);
    constexpr double most = Silhouettes::most_growth_px;
    if (std::abs(growth) >= least_growth_px)
        silhouettes.grow_masks(std::clamp(silhouettes.growth_px() + growth, -most, most));
}

/// Step 2 from the coarsest image level to the photographs themselves, for which each face becomes four: what a coarse
/// level shows, a coarse mesh can follow. The finer mesh costs its time once and gains 8 to 15 % at every count that is
/// simplified or refined from it (pot, 36 views: 0.076 % of the diagonal at 2,500 vertices without, 0.066 % with it).
/// On the way the views are aligned, if their cameras need it: with poses that are half a pixel off, nefertiti at
/// 10,000 vertices is 0.036 % off without it and 0.024 % with it, and Psi is 50 without it and 8 with it, as from true
/// poses. So are the borders of the masks, which silhouettes would else hold the surface to: with masks that are two
/// pixels too small it is 0.024 % off without that and 0.016 % with it, two pixels too large 0.021 and 0.018 %.
/// @param backend  holds the images of `start`
void optimise_coarse_to_fine(PhotoBackend& backend, Start& start, const ProgressFn& tell, const std::stop_token& stop) {
    const int first = std::min(coarsest_level, backend.n_levels() - 1);
    Mesh& mesh = start.mesh;
    bool are_off = false;
    for (int level = first; level >= 0; --level) {
        OptimiseOptions options;
        options.level = level;
        options.rounds = level == 0 ? 3 : 2;
        if (level > 0) options.silhouette_reach_px = contour_reach_px;
        if (level == 0) mesh = subdivide(mesh);
        optimise_surface(backend, start.silhouettes, mesh.vertices, mesh.triangles, {}, start.guessed.vertices(mesh),
                         options, stop);
        align_masks(start);
        if (level == 1) are_off = align_views(start, level, least_shift_px);
        if (level == 0 && are_off) align_views(start, level, 0.0);
        // Each level takes about twice the time of the one before, fine_surface() as long as all of them.
        const double share = (std::exp2(first - level + 1) - 1) / (std::exp2(first + 2) - 1);
        tell({Stage::optimise, share, mesh.n_vertices(), 0});
    }
}

/// What stands for the fine surface when base and splits are fitted to it.
TrueSurface sampled(const Mesh& fine) { return {fine, samples_per_vertex * fine.n_vertices()}; }

/// The base of the log: as near to the fitted surface as its few vertices can be. Optimised against the photographs it
/// is worse, since on facets as coarse as these they disagree whatever one does (pot, 36 views, at 2,500 vertices:
/// 0.058 % of the diagonal, fitted 0.052 %).
Mesh fit_base(const Mesh& fine, Mesh first_stage, const TrueSurface& fitted, int n_vertices) {
    SurfaceMeter meter(fitted);
    return fit_coarse_mesh(fine, std::move(first_stage), n_vertices, meter);
}

/// The optimised surface again, with its vertices where it bends: simplified by quadrics, subdivided and optimised. The
/// even mesh, and whatever is simplified from it, has saw teeth where its edges cross relief.
/// @param n_log  vertices of the log that will approach it
Mesh fine_surface(PhotoBackend& backend, Start& start, int n_log, const std::stop_token& stop) {
    const int n_wanted = static_cast<int>(fine_over_log * n_log);
    const int n_vertices = std::max(start.n_even, std::min(n_wanted, start.n_resolved));
    Mesh fine = subdivide(decimate(start.mesh, static_cast<int>(simplified_part * n_vertices)));
    const std::vector<Vec3> simplified(fine.vertices);
    optimise_surface(backend, start.silhouettes, fine.vertices, fine.triangles, {}, start.guessed.vertices(fine), {},
                     stop);
    keep_apart(fine, simplified);
    untangle(fine);
    return fine;
}

RefineOptions refine_options(const ReconstructOptions& options) {
    RefineOptions refinement;
    refinement.n_vertices = options.n_vertices;
    refinement.by_area = options.method == Method::uniform;
    refinement.follows_images = options.follows_images || refinement.by_area;
    return refinement;
}

/// The state that every decoder has after the base, in the own frame, and what the images say of it.
struct SentBase {
    RefinableMesh state;
    DistortionPoint distortion;
};

/// Gives the sink the base with its attributes. It is measured twice: before, since the rules depend on Psi, and as the
/// sink has numbered it, which changes Psi's seventh digit (bowl).
SentBase send_base(const BaseMesh& base, const Grid& grid, const CaptureFrame& frame, const PhotoImages& images,
                   PhotoBackend& backend, const ReconstructOptions& options, ModelSink& sink) {
    const bool is_noisy = measure_surface(backend, RefinableMesh(base, grid, {}).to_mesh()) > most_credible_psi;
    const RefinementRules rules{.step_ratio = is_noisy ? noisy_log_steps : log_steps};
    RefinableMesh state(sink.start(frame.in_world(grid), rules, base), grid, rules);
    const StateAttributes attributes = state_attributes(backend, images, state, 0, refine_options(options));
    sink.base_attributes(attributes.colours, attributes.distortion);
    return {std::move(state), attributes.distortion};
}

/// Step 3: progressive refinement.
/// @param known  what the images say of the state, if they were asked already
ReconstructResult refine_from(RefinementPoint point, const std::optional<DistortionPoint>& known,
                              const RefinementScene& scene, PhotoBackend& backend, const ReconstructOptions& options,
                              ModelSink& sink, const ProgressFn& tell, const std::stop_token& stop,
                              RefinementJournal* journal) {
    RefineOptions refinement = refine_options(options);
    if (options.method == Method::flow) refinement.n_vertices = point.state.n_vertices();
    ReconstructResult result;
    result.curve = refine(
        point.state, backend, scene, refinement, sink,
        [&](const CurvePoint& reached) {
            if (journal) journal->batch(point.is_rejected);
            const double part = static_cast<double>(reached.n_vertices - options.n_coarse) /
                                std::max(1, options.n_vertices - options.n_coarse);
            tell({Stage::refine, part, reached.n_vertices, reached.psi});
        },
        stop, &point.is_rejected, known);
    result.stopped = stop.stop_requested();
    if (!journal || !result.stopped) sink.finish();
    return result;
}

}  // namespace

const char* stage_name(Stage stage) {
    switch (stage) {
        case Stage::hull:
            return "hull";
        case Stage::poisson:
            return "poisson";
        case Stage::remesh:
            return "remesh";
        case Stage::optimise:
            return "optimise";
        case Stage::refine:
            return "refine";
    }
    return "";
}

ReconstructResult reconstruct(Capture capture, const ReconstructOptions& options, ModelSink& sink,
                              const ProgressFn& progress, std::stop_token stop, RefinementJournal* journal) {
    check(options);
    const auto tell = [&](const Progress& p) {
        if (progress) progress(p);
    };

    const CaptureFrame frame = to_own_frame(capture);
    const bool fixed_rate = options.method == Method::flow;
    const int n_base = fixed_rate ? options.n_vertices : options.n_coarse;
    Start start = make_start(std::move(capture), options, frame, sink, tell);
    auto& [images, silhouettes, guessed, mesh, n_resolved, n_even, gains, shifts] = start;

    const auto backend = options.backend(images, Sampling::adaptive);
    // One of its own where two surfaces are looked at in turns or samples are shared out otherwise: a device need not
    // hold the photographs twice.
    const auto own_sampler = fixed_rate || options.sampling != Sampling::adaptive
                                 ? options.backend(images, options.sampling)
                                 : std::unique_ptr<PhotoBackend>();
    PhotoBackend& sampler = own_sampler ? *own_sampler : *backend;
    std::vector<double> iterations;
    tell({Stage::optimise, 0, mesh.n_vertices(), 0});
    if (fixed_rate) {
        iterations = flow_at_fixed_rate(sampler, *backend, options, mesh, tell, stop);
    } else {
        optimise_coarse_to_fine(sampler, start, tell, stop);
        n_even = mesh.n_vertices();
        guessed = confirm_guesses(sampler, silhouettes, guessed, mesh, {}, stop);
    }
    Mesh fine = fixed_rate ? mesh : fine_surface(*backend, start, options.n_vertices, stop);
    if (journal && stop.stop_requested()) return {.curve = {}, .iterations = {}, .stopped = true};
    std::optional<TrueSurface> fitted;
    Mesh first_stage;
    parallel_invoke([&] { fitted.emplace(sampled(fine)); },
                    [&] { first_stage = fixed_rate ? Mesh{} : first_coarse_stage(fine, n_base); });
    if (!fixed_rate) mesh = fit_base(fine, std::move(first_stage), *fitted, n_base);

    // From here on only the decoded integer state counts.
    const Grid grid = make_grid(mesh, options.n_vertices);
    const BaseMesh base = to_base(mesh, grid);
    if (journal)
        journal->begin({.grid = grid,
                        .base = base,
                        .gains = gains,
                        .shifts = shifts,
                        .mask_growth_px = silhouettes.growth_px(),
                        .guess_points = {guessed.points().begin(), guessed.points().end()},
                        .guess_reach = guessed.reach(),
                        .fitted = std::move(fine)});
    SentBase sent = send_base(base, grid, frame, images, *backend, options, sink);
    RefinementPoint point{std::move(sent.state), {}};
    if (journal) journal->batch(point.is_rejected);
    ReconstructResult result = refine_from(std::move(point), sent.distortion, {images, silhouettes, guessed, *fitted},
                                           *backend, options, sink, tell, stop, journal);
    result.iterations = std::move(iterations);
    return result;
}

ReconstructResult resume(Capture capture, const ReconstructOptions& options, const RefinementStart& start,
                         std::optional<RefinementPoint> point, ModelSink& sink, const ProgressFn& progress,
                         std::stop_token stop, RefinementJournal& journal) {
    check(options);
    const auto tell = [&](const Progress& p) {
        if (progress) progress(p);
    };
    const auto require_one_a_view = [&](const char* what, std::size_t n) {
        if (n != capture.views.size())
            throw InputError("resume: expected " + std::to_string(capture.views.size()) + " " + what +
                             ", one a view, got " + std::to_string(n));
    };
    if (!start.gains.empty()) require_one_a_view("gains", start.gains.size());
    for (const auto& shifts : start.shifts) require_one_a_view("shifts", shifts.size());
    static_assert(Silhouettes::most_growth_px == 4);
    if (!(std::abs(start.mask_growth_px) <= Silhouettes::most_growth_px))
        throw InputError("resume: expected masks to grow by 4 px at most, got " + std::to_string(start.mask_growth_px) +
                         " px");

    tell({Stage::refine, 0, 0, 0});
    const CaptureFrame frame = to_own_frame(capture);
    PhotoImages images = make_photo_images(capture);
    for (View& view : capture.views) view.image = {};
    if (!start.gains.empty()) divide_by_gains(images, start.gains);
    Silhouettes silhouettes(capture);
    capture = {};
    for (const auto& shifts : start.shifts) {
        shift_views(images, shifts);
        silhouettes.shift_views(shifts);
    }
    if (start.mask_growth_px != 0) silhouettes.grow_masks(start.mask_growth_px);
    const GuessedSurface guessed(start.guess_points, start.guess_reach);
    const TrueSurface fitted = sampled(start.fitted);
    const auto backend = options.backend(images, Sampling::adaptive);
    std::optional<DistortionPoint> known;
    if (point) {
        point->state.move_grid(start.grid.origin, start.grid.unit);
    } else {
        SentBase sent = send_base(start.base, start.grid, frame, images, *backend, options, sink);
        point = {std::move(sent.state), {}};
        known = sent.distortion;
        journal.batch(point->is_rejected);
    }
    return refine_from(std::move(*point), known, {images, silhouettes, guessed, fitted}, *backend, options, sink, tell,
                       stop, &journal);
}

}  // namespace anyrate
