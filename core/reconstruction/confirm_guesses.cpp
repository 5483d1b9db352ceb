#include "core/reconstruction/confirm_guesses.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/reconstruction/face_distortions.h"
#include "core/reconstruction/fairing.h"
#include "core/reconstruction/mend_patches.h"
#include "core/reconstruction/optimise_surface.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

enum class Standing : char { shown, doubtful, guessed };

// Guesses, with the ring around them as far as no two views see it; what is doubtful: shown by the images, which
// disagree there; and the surroundings of both.
std::vector<Standing> find_standings(std::span<const char> is_guessed, std::span<const std::optional<double>> G,
                                     const OneRings& rings, const ConfirmGuessOptions& options, bool spreads) {
    const std::optional<double> usual = usual_distortion(G, is_guessed);
    std::vector<Standing> standings(is_guessed.size(), Standing::shown);
    for (std::size_t v = 0; v < standings.size(); ++v) {
        if (is_guessed[v] != 0)
            standings[v] = Standing::guessed;
        else if (usual && G[v] && *G[v] > options.agreement * *usual)
            standings[v] = Standing::doubtful;
    }
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(standings.size()); ++v)
        if (spreads && standings[at(v)] == Standing::shown && !G[at(v)] &&
            std::ranges::any_of(rings.neighbours(v), [&](std::int32_t w) { return is_guessed[at(w)] != 0; }))
            standings[at(v)] = Standing::guessed;
    const std::vector<Standing> inner = standings;
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(inner.size()); ++v)
        if (inner[at(v)] == Standing::shown &&
            std::ranges::any_of(rings.neighbours(v), [&](std::int32_t w) { return inner[at(w)] != Standing::shown; }))
            standings[at(v)] = Standing::doubtful;
    return standings;
}

/// What a pass leaves to the next.
struct Pass {
    std::vector<char> is_guessed;      ///< one flag a vertex: what is still a guess
    std::vector<std::int32_t> active;  ///< vertices that were on trial, ascending; no others were moved
};

/// @param distortions  of the mesh
/// @param guesses      one flag a vertex
/// @param spreads      whether what no two views see beside a guess becomes one
Pass confirm_once(PhotoBackend& backend, Silhouettes& silhouettes, const OneRings& rings,
                  const FaceDistortions& distortions, std::span<const char> guesses, Mesh& mesh,
                  const ConfirmGuessOptions& options, bool spreads, const std::stop_token& stop) {
    const auto before = distortions.of_vertices(rings, mesh.n_vertices());
    const std::vector<Standing> standings = find_standings(guesses, before, rings, options, spreads);
    std::vector<char> on_trial(standings.size());
    Pass pass{std::vector<char>(standings.size(), 0), {}};
    auto& [is_guessed, active] = pass;
    for (std::size_t v = 0; v < standings.size(); ++v)
        if (standings[v] != Standing::shown) {
            on_trial[v] = 1;
            active.push_back(static_cast<std::int32_t>(v));
        }
    if (active.empty()) return pass;

    Mesh trial = mesh;
    fair(trial, on_trial, options.attachment);
    for (int level = std::min(options.coarsest_level, backend.n_levels() - 1); level >= 0; --level) {
        OptimiseOptions optimise;
        optimise.level = level;
        optimise.rounds = options.rounds;
        optimise_surface(backend, silhouettes, trial.vertices, trial.triangles, active, {}, optimise, stop);
    }

    FaceDistortions of_trial = distortions;
    of_trial.measure_around(active, trial, rings);
    const auto after = of_trial.of_vertices(rings, trial.n_vertices());
    const std::optional<double> usual = usual_distortion(after, on_trial);
    const auto agrees = [&](std::int32_t v) {
        return on_trial[at(v)] == 0 || (usual && after[at(v)] && *after[at(v)] <= options.agreement * *usual);
    };
    // No image speaks for the place of a doubtful vertex rather than for the trial's.
    const auto improves = [&](std::int32_t v) {
        return standings[at(v)] == Standing::doubtful &&
               (!after[at(v)] ? !before[at(v)] : before[at(v)] && *after[at(v)] < *before[at(v)]);
    };
    const auto is_settled = [&](std::int32_t v) {
        // Among wrong neighbours a vertex agrees by chance.
        if (agrees(v) && std::ranges::all_of(rings.neighbours(v), agrees)) return true;
        return improves(v) && std::ranges::all_of(rings.neighbours(v), [&](std::int32_t w) {
                   return standings[at(w)] == Standing::guessed || agrees(w) || improves(w);
               });
    };
    const auto is_hopeless = [&](std::int32_t v) {
        const auto is_far_off = [&](const std::optional<double>& G) { return *G > options.hopeless * *usual; };
        return usual && before[at(v)] && is_far_off(before[at(v)]) && (!after[at(v)] || is_far_off(after[at(v)]));
    };
    for (const std::int32_t v : active) {
        const bool settled = is_settled(v);
        if (settled) mesh.vertices[at(v)] = trial.vertices[at(v)];
        is_guessed[at(v)] = !settled && (standings[at(v)] == Standing::guessed || is_hopeless(v));
    }
    fair(mesh, is_guessed, options.attachment);
    return pass;
}

}  // namespace

GuessedSurface confirm_guesses(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed,
                               Mesh& mesh, const ConfirmGuessOptions& options, const std::stop_token& stop) {
    const OneRings rings(mesh);
    FaceDistortions distortions(backend, mesh);
    std::vector<char> guesses = guessed.vertices(mesh);
    ConfirmGuessOptions of_pass = options;
    for (int i = 0; i < options.passes && !stop.stop_requested(); ++i) {
        const bool spreads = i < options.spreading_passes;
        Pass pass = confirm_once(backend, silhouettes, rings, distortions, guesses, mesh, of_pass, spreads, stop);
        guesses = std::move(pass.is_guessed);
        of_pass.coarsest_level = 0;
        if (pass.active.empty()) break;
        distortions.measure_around(pass.active, mesh, rings);
    }
    if (options.passes > 0 && !stop.stop_requested())
        mend_patches(backend, silhouettes, std::move(distortions), options.coarsest_level, guesses, mesh, stop);
    return guessed_part(mesh, guesses);
}

}  // namespace anyrate
