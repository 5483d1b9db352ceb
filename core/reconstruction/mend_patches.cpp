#include "core/reconstruction/mend_patches.h"

#include <optional>
#include <span>
#include <utility>

#include "core/mesh/subdivide.h"
#include "core/reconstruction/guessed_surface.h"
#include "core/reconstruction/replace_patches.h"

namespace anyrate {
namespace {

/// Of the mesh as it is. Where noise outweighs the texture only the lower doubt finds a web behind an ear (a tenth of
/// the texture: 0.0220 % of the diagonal without it, 0.0204 with it); by it alone from the start folds of clean
/// photographs close (Psi of nefertiti's 10,000 vertices: 7.4 instead of 7.1). Without the smaller patches cropped
/// photographs are 3 % worse; with 3 and 4 rings as well nothing is nearer.
constexpr PatchOptions passes[] = {
    {.doubt = 25, .n_rings = 2}, {.doubt = 25, .n_rings = 1}, {.doubt = 10, .n_rings = 2}, {.doubt = 10, .n_rings = 1}};

/// Of halved edges, with patches as wide. The lower doubt again gains nothing.
constexpr PatchOptions halved_passes[] = {{.level = 0, .doubt = 25, .n_rings = 4},
                                          {.level = 0, .doubt = 25, .n_rings = 2}};

/// Out of folds and pits that the energy rests in, however wrong (pot, 36 views, 10,000 vertices: 0.0209 % of the
/// diagonal off without these passes, 0.0193 with them; no push, but twelve rounds, 0.0198; from level 2 0.0196; twice
/// the rounds, for 6 % more time, or pushes by 2 edges as well gain nothing more).
constexpr PatchOptions pushed_passes[] = {{.level = 1, .doubt = 5, .n_rings = 1, .push = -1},
                                          {.level = 1, .doubt = 5, .n_rings = 1, .push = 1}};

constexpr double halved_doubt = 10;  ///< least G of a vertex whose edges are halved, in medians; 25: bust 2 % worse
constexpr int halved_rings = 2;      ///< around it

/// One flag a vertex.
std::vector<char> find_halved(const FaceDistortions& distortions, std::span<const char> is_guessed, const Mesh& mesh) {
    const OneRings rings(mesh);
    const auto G = distortions.of_vertices(rings, mesh.n_vertices());
    std::vector<char> flags = doubtful_or_guessed(G, is_guessed, halved_doubt);
    for (int i = 0; i < halved_rings; ++i) grow_by_ring(flags, rings);
    return flags;
}

}  // namespace

void mend_patches(PhotoBackend& backend, Silhouettes& silhouettes, FaceDistortions distortions, int level,
                  std::vector<char>& is_guessed, Mesh& mesh, const std::stop_token& stop) {
    const auto replace = [&](std::span<const PatchOptions> each, std::optional<int> from_level = {}) {
        const OneRings rings(mesh);
        for (PatchOptions options : each) {
            options.level = from_level.value_or(options.level);
            replace_patches(backend, silhouettes, rings, distortions, is_guessed, mesh, options, stop);
        }
    };
    replace(passes, level);
    const std::vector<char> halved = find_halved(distortions, is_guessed, mesh);
    const GuessedSurface guessed = guessed_part(mesh, is_guessed);
    Mesh finer = subdivide_where(mesh, halved);
    if (finer.n_vertices() == mesh.n_vertices() || stop.stop_requested()) return;
    mesh = std::move(finer);
    is_guessed = guessed.vertices(mesh);
    distortions = FaceDistortions(backend, mesh);
    replace(halved_passes);
    replace(pushed_passes);
}

}  // namespace anyrate
