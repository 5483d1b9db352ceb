#include "core/reconstruction/standing_depth.h"

#include <algorithm>
#include <utility>

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Around the box that is asked for, so that it still holds the next ones: what moves is asked for where it is by then.
constexpr int margin = 8;  // pixels

PixelBox with_margin(const PixelBox& box, const PhotoLevel& image) {
    return {std::max(0, box.x0 - margin), std::max(0, box.y0 - margin), std::min(image.width, box.x1 + margin),
            std::min(image.height, box.y1 + margin)};
}

}  // namespace

bool StandingDepth::holds(const PhotoImages& images, int level, const SurfaceView& surface,
                          std::span<const std::int32_t> moving) const {
    if (level != level_ || images.views.size() != views_.size() || surface.vertices.size() != vertices_.size() ||
        !std::ranges::equal(moving, moving_faces_) || !std::ranges::equal(surface.triangles, triangles_))
        return false;
    for (std::size_t i = 0; i < views_.size(); ++i)
        if (images.views[i].levels[at(level)].P != views_[i].P) return false;
    for (std::size_t v = 0; v < vertices_.size(); ++v)
        if (stands_[v] != 0 && surface.vertices[v] != vertices_[v]) return false;
    return true;
}

void StandingDepth::keep(const PhotoImages& images, int level, const SurfaceView& surface,
                         std::span<const std::int32_t> moving) {
    if (holds(images, level, surface, moving)) return;
    *this = {};
    level_ = level;
    for (const PhotoView& view : images.views) views_.push_back({view.levels[at(level)].P, {}, {}});
    vertices_.assign(surface.vertices.begin(), surface.vertices.end());
    triangles_.assign(surface.triangles.begin(), surface.triangles.end());
    moving_faces_.assign(moving.begin(), moving.end());
    std::vector<char> moves(vertices_.size());
    stands_.resize(vertices_.size());
    auto next_moving = moving.begin();
    for (std::size_t f = 0; f < triangles_.size(); ++f) {
        const bool is_moving = next_moving != moving.end() && at(*next_moving) == f;
        if (is_moving) ++next_moving;
        (is_moving ? moving_ : standing_).push_back(triangles_[f]);
        for (const std::int32_t v : triangles_[f]) (is_moving ? moves : stands_)[at(v)] = 1;
    }
    for (std::size_t v = 0; v < moves.size(); ++v)
        if (moves[v] != 0) moving_vertices_.push_back(static_cast<std::int32_t>(v));
}

InverseDepthPart StandingDepth::draw(std::size_t view, const PhotoLevel& image, const PixelBox& box,
                                     std::span<const ScreenVertex> vertices) {
    View& standing = views_[view];
    if (!standing.box.holds(box)) {
        standing.box = with_margin(box, image);
        const std::vector<ScreenVertex> all = project(image, {vertices_, triangles_});
        standing.depth = render_inverse_depth_in(standing.box, image.width, image.height, all,
                                                 triangles_at(standing.box, all, standing_));
    }
    InverseDepthPart depth = standing.depth;
    draw_inverse_depth(standing.box, image.width, image.height, vertices, moving_, depth);
    return depth;
}

}  // namespace anyrate
