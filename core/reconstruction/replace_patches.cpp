#include "core/reconstruction/replace_patches.h"

#include <algorithm>
#include <vector>

#include "core/reconstruction/fairing.h"
#include "core/reconstruction/optimise_round.h"
#include "core/reconstruction/optimise_surface.h"
#include "core/reconstruction/robust_terms.h"
#include "core/reconstruction/surface_view.h"

namespace anyrate {
namespace {

/// Of a patch to its place, see fair(): bumps of up to a hundred edges go.
constexpr double attachment = 1e-6;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// The connected parts of what is flagged.
struct Patches {
    std::vector<std::int32_t> of_vertex;  ///< one a vertex of the mesh, -1 in none
    std::vector<std::int32_t> vertices;   ///< of all patches, ascending
    std::size_t n_patches = 0;

    Patches(std::span<const char> flags, const OneRings& rings) : of_vertex(flags.size(), -1) {
        for (std::int32_t v = 0; v < static_cast<std::int32_t>(flags.size()); ++v) {
            if (flags[at(v)] == 0) continue;
            vertices.push_back(v);
            if (of_vertex[at(v)] < 0) fill(v, static_cast<std::int32_t>(n_patches++), flags, rings);
        }
    }

    /// -1 if no corner is in one. Where two corners are, they are in the same.
    std::int32_t of_face(const Triangle& t) const {
        return std::max({of_vertex[at(t[0])], of_vertex[at(t[1])], of_vertex[at(t[2])]});
    }

private:
    void fill(std::int32_t first, std::int32_t patch, std::span<const char> flags, const OneRings& rings) {
        std::vector<std::int32_t> front{first};
        of_vertex[at(first)] = patch;
        while (!front.empty()) {
            const std::int32_t v = front.back();
            front.pop_back();
            for (const std::int32_t w : rings.neighbours(v))
                if (flags[at(w)] != 0 && of_vertex[at(w)] < 0) {
                    of_vertex[at(w)] = patch;
                    front.push_back(w);
                }
        }
    }
};

/// Flags n rings more. @return one a vertex: 1 where there was a flag, less in each ring, 0 beyond the last
std::vector<double> grow_by_rings(std::vector<char>& flags, int n, const OneRings& rings) {
    std::vector<double> heights(flags.begin(), flags.end());
    for (int i = 0; i < n; ++i) {
        grow_by_ring(flags, rings);
        for (std::size_t v = 0; v < flags.size(); ++v) heights[v] += flags[v] != 0 ? 1 : 0;
    }
    for (double& height : heights) height /= n + 1;
    return heights;
}

/// @param distance  mean edges that a vertex of height 1 moves outwards
void push(Mesh& mesh, std::span<const std::int32_t> vertices, std::span<const double> heights, double distance,
          const OneRings& rings) {
    const std::vector<Vec3> normals = vertex_normals(mesh, rings);
    const std::vector<double> edges = mean_edge_lengths(mesh, rings);
    for (const std::int32_t v : vertices)
        mesh.vertices[at(v)] += distance * heights[at(v)] * edges[at(v)] * normals[at(v)];
}

/// What the images say of a patch.
struct Evidence {
    double phi = 0;  ///< robust
    double n_samples = 0;
};

std::vector<Evidence> evidence_of(const Patches& patches, std::span<const Triangle> triangles,
                                  std::span<const TriangleDistortion> faces, double credible) {
    std::vector<Evidence> evidence(patches.n_patches);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const std::int32_t patch = patches.of_face(triangles[f]);
        if (patch < 0 || faces[f].n_samples <= 0) continue;
        evidence[at(patch)].phi += robust_phi(faces[f], credible);
        evidence[at(patch)].n_samples += faces[f].n_samples;
    }
    return evidence;
}

bool is_better(const Evidence& now, const Evidence& before, const PatchOptions& options) {
    return now.n_samples > options.least_evidence * before.n_samples &&
           now.phi * before.n_samples < options.most_distortion * before.phi * now.n_samples;
}

}  // namespace

std::vector<char> doubtful_or_guessed(std::span<const std::optional<double>> G, std::span<const char> is_guessed,
                                      double doubt) {
    std::vector<char> flags(is_guessed.size());
    const std::optional<double> usual = usual_distortion(G, is_guessed);
    if (!usual) return flags;
    for (std::size_t v = 0; v < flags.size(); ++v) flags[v] = G[v] && (is_guessed[v] != 0 || *G[v] > doubt * *usual);
    return flags;
}

void replace_patches(PhotoBackend& backend, Silhouettes& silhouettes, const OneRings& rings,
                     FaceDistortions& distortions, std::span<char> is_guessed, Mesh& mesh, const PatchOptions& options,
                     const std::stop_token& stop) {
    const auto G = distortions.of_vertices(rings, mesh.n_vertices());
    const std::optional<double> usual = usual_distortion(G, is_guessed);
    if (!usual) return;
    std::vector<char> flags = doubtful_or_guessed(G, is_guessed, options.doubt);
    const std::vector<double> heights = grow_by_rings(flags, options.n_rings, rings);
    const Patches patches(flags, rings);
    if (patches.vertices.empty()) return;

    Mesh trial = mesh;
    if (options.push)
        push(trial, patches.vertices, heights, *options.push, rings);
    else
        fair(trial, flags, attachment);
    for (int level = std::min(options.level, backend.n_levels() - 1); level >= 0; --level) {
        const OptimiseOptions optimise{.level = level, .rounds = options.rounds};
        optimise_surface(backend, silhouettes, trial.vertices, trial.triangles, patches.vertices, {}, optimise, stop);
    }
    FaceDistortions of_trial = distortions;
    of_trial.measure_around(patches.vertices, trial, rings);

    const double credible = round_rules().outlier * *usual;
    const std::vector<Evidence> before = evidence_of(patches, mesh.triangles, distortions.faces(), credible),
                                after = evidence_of(patches, mesh.triangles, of_trial.faces(), credible);
    std::vector<char> is_replaced(patches.n_patches);
    for (std::size_t i = 0; i < patches.n_patches; ++i) is_replaced[i] = is_better(after[i], before[i], options);
    const auto moves = [&](std::int32_t v) { return is_replaced[at(patches.of_vertex[at(v)])] != 0; };
    for (const std::int32_t v : patches.vertices)
        if (moves(v)) mesh.vertices[at(v)] = trial.vertices[at(v)];
    distortions.take(of_trial, [&](std::int32_t face) {
        const std::int32_t patch = patches.of_face(mesh.triangles[at(face)]);
        return patch >= 0 && is_replaced[at(patch)] != 0;
    });
    const auto now = distortions.of_vertices(rings, mesh.n_vertices());
    for (const std::int32_t v : patches.vertices)
        if (moves(v) && now[at(v)] && *now[at(v)] < options.doubt * *usual) is_guessed[at(v)] = 0;
}

}  // namespace anyrate
