#include "tests/bench/silhouette_overlap.h"

#include "core/simulation/render.h"

namespace anyrate::bench {

double silhouette_overlap(const Mesh& surface, const View& view) {
    const Model black{.surface = surface,
                      .normals = std::vector<Vec3>(surface.vertices.size(), Vec3::UnitZ()),
                      .appearance = [](const Vec3&, const Vec3&) { return Vec3(Vec3::Zero()); }};
    const MaskImage rendered = render_view(black, view.camera, "", {.supersampling = 3, .noise = 0}).mask;
    long long n_both = 0, n_any = 0;
    for (std::size_t i = 0; i < rendered.pixels.size(); ++i) {
        n_both += rendered.pixels[i] != 0 && view.mask.pixels[i] != 0;
        n_any += rendered.pixels[i] != 0 || view.mask.pixels[i] != 0;
    }
    return n_any == 0 ? 0.0 : static_cast<double>(n_both) / static_cast<double>(n_any);
}

}  // namespace anyrate::bench
