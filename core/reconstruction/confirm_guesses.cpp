#include "core/reconstruction/confirm_guesses.h"

#include <algorithm>
#include <optional>

#include "core/reconstruction/distortion.h"
#include "core/reconstruction/optimise_surface.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

std::vector<std::optional<double>> vertex_distortions(PhotoBackend& backend, const Mesh& mesh, const OneRings& rings) {
    backend.set_surface(mesh, 0, 1.0);
    std::vector<TriangleQuery> queries(mesh.triangles.size());
    for (std::size_t f = 0; f < queries.size(); ++f) {
        queries[f].face = static_cast<std::int32_t>(f);
        for (std::size_t k = 0; k < 3; ++k) queries[f].corners[k] = mesh.vertices[at(mesh.triangles[f][k])];
    }
    return vertex_distortion(rings, mesh.n_vertices(), backend.distortions(queries));
}

/// Median of G over the vertices that are no guess; nothing if there is none.
std::optional<double> usual_distortion(std::span<const std::optional<double>> G, std::span<const char> is_guessed) {
    std::vector<double> known;
    for (std::size_t v = 0; v < G.size(); ++v)
        if (is_guessed[v] == 0 && G[v]) known.push_back(*G[v]);
    if (known.empty()) return std::nullopt;
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    return *middle;
}

GuessedSurface confirm_once(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed, Mesh& mesh,
                            const ConfirmGuessOptions& options, const std::stop_token& stop) {
    const std::vector<char> is_guessed = guessed.vertices(mesh);
    std::vector<std::int32_t> active;
    for (std::size_t v = 0; v < is_guessed.size(); ++v)
        if (is_guessed[v] != 0) active.push_back(static_cast<std::int32_t>(v));
    if (active.empty()) return {};

    Mesh trial = mesh;
    for (int level = std::min(options.coarsest_level, backend.n_levels() - 1); level >= 0; --level) {
        OptimiseOptions optimise;
        optimise.level = level;
        optimise.rounds = options.rounds;
        optimise_surface(backend, silhouettes, trial.vertices, trial.triangles, active, {}, optimise, stop);
    }

    const OneRings rings(trial);
    const auto G = vertex_distortions(backend, trial, rings);
    const std::optional<double> usual = usual_distortion(G, is_guessed);
    const auto agrees = [&](std::int32_t v) {
        return is_guessed[at(v)] == 0 || (usual && G[at(v)] && *G[at(v)] <= options.agreement * *usual);
    };
    const std::vector<Vec3> normals = vertex_normals(mesh, rings);
    const std::vector<double> edges = mean_edge_lengths(mesh, rings);
    std::vector<OrientedPoint> left;
    double reach = 0;
    for (const std::int32_t v : active) {
        // Among wrong neighbours a vertex agrees by chance.
        if (agrees(v) && std::ranges::all_of(rings.neighbours(v), agrees)) {
            mesh.vertices[at(v)] = trial.vertices[at(v)];
        } else {
            left.push_back({mesh.vertices[at(v)], normals[at(v)], 0.0});
            reach += edges[at(v)];
        }
    }
    if (left.empty()) return {};
    const auto n_left = static_cast<double>(left.size());
    return GuessedSurface(std::move(left), reach / n_left);
}

}  // namespace

GuessedSurface confirm_guesses(PhotoBackend& backend, Silhouettes& silhouettes, const GuessedSurface& guessed,
                               Mesh& mesh, const ConfirmGuessOptions& options, const std::stop_token& stop) {
    GuessedSurface left = confirm_once(backend, silhouettes, guessed, mesh, options, stop);
    for (int pass = 1; pass < options.passes && !stop.stop_requested(); ++pass)
        left = confirm_once(backend, silhouettes, left, mesh, options, stop);
    return left;
}

}  // namespace anyrate
