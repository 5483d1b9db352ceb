#include "gpu/photo_textures.h"

#include <algorithm>

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Level 0 of an array into which all levels of all views fit: those of a pyramid are rounded up, those of a texture
/// down.
int padded(const PhotoImages& images, int PhotoLevel::*side) {
    int largest = 1;
    for (const PhotoView& view : images.views) largest = std::max(largest, view.levels.front().*side);
    const int step = 1 << (images.n_levels() - 1);
    return (largest + step - 1) / step * step;
}

}  // namespace

PhotoTextures::PhotoTextures(const PhotoImages& images, DeviceWork& work)
    : texture_(padded(images, &PhotoLevel::width), padded(images, &PhotoLevel::height), images.n_views(),
               images.n_levels()) {
    for (int v = 0; v < images.n_views(); ++v)
        for (int l = 0; l < images.n_levels(); ++l) {
            const PhotoLevel& level = images.views[at(v)].levels[at(l)];
            texture_.write(l, v, level.width, level.height, level.rgba.data());
            work.bytes_up += level.rgba.size();
        }
}

std::vector<double> camera_block(const PhotoImages& images, int level, std::span<const double> of_view) {
    std::vector<double> block;
    block.reserve(camera_block_stride * images.views.size());
    for (std::size_t i = 0; i < images.views.size(); ++i) {
        const PhotoView& view = images.views[i];
        const Mat34& P = view.levels[at(level)].P;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column) block.push_back(P(row, column));
        block.insert(block.end(), {view.centre.x(), view.centre.y(), view.centre.z(), of_view[i]});
    }
    return block;
}

std::vector<std::int32_t> size_block(const PhotoImages& images, int level) {
    std::vector<std::int32_t> block;
    for (const PhotoView& view : images.views) {
        block.push_back(view.levels[at(level)].width);
        block.push_back(view.levels[at(level)].height);
    }
    return block;
}

}  // namespace anyrate
