#include "gpu/device_silhouettes.h"

#include <algorithm>
#include <span>

namespace anyrate {
namespace {

using Distances = Image<std::int8_t>;

constexpr std::size_t coverage_stride = 12;  // numbers a view has for DepthPass: P

void append(std::vector<double>& block, const Mat34& P) {
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) block.push_back(P(row, column));
}

/// Four distances to a texel, the left-most in the lowest byte; rows are filled up with zeros.
std::vector<std::uint32_t> packed(const Distances& image) {
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    const std::size_t row = (width + 3) / 4;
    std::vector<std::uint32_t> texels(row * height, 0);
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            texels[y * row + x / 4] |= std::uint32_t{static_cast<std::uint8_t>(image.pixels[y * width + x])}
                                       << (8 * (x % 4));
    return texels;
}

}  // namespace

DeviceSilhouettes::DeviceSilhouettes() : depth_pass_(coverage_stride) {}

void DeviceSilhouettes::set(const Silhouettes& silhouettes, DeviceWork& work) {
    copy_distances(silhouettes, work);
    std::vector<double> cameras, coverage_cameras;
    std::vector<std::int32_t> coverage_sizes;
    int width = 1, height = 1;
    for (const Silhouettes::View& view : silhouettes.views()) {
        const PhotoLevel& level = view.coverage_level;
        append(cameras, view.P);
        cameras.insert(cameras.end(), {view.centre.x(), view.centre.y(), view.centre.z(), view.coverage_scale});
        for (const int side : {view.distance->width, view.distance->height, level.width, level.height})
            cameras.push_back(side);
        append(coverage_cameras, level.P);
        coverage_sizes.insert(coverage_sizes.end(), {level.width, level.height});
        width = std::max(width, level.width);
        height = std::max(height, level.height);
    }
    work.write<double>(cameras_, cameras);
    work.write<double>(coverage_.cameras, coverage_cameras);
    work.write<std::int32_t>(coverage_.sizes, coverage_sizes);
    if (on_device_.empty() || (coverage_.inverse_depth && width == coverage_width_ && height == coverage_height_))
        return;
    coverage_.inverse_depth.reset();
    coverage_.inverse_depth.emplace(width, height, static_cast<int>(on_device_.size()), 1);
    coverage_width_ = width;
    coverage_height_ = height;
}

void DeviceSilhouettes::copy_distances(const Silhouettes& silhouettes, DeviceWork& work) {
    const auto views = silhouettes.views();
    if (std::ranges::equal(views, on_device_, {}, &Silhouettes::View::distance)) return;
    on_device_.clear();
    distances_.reset();
    coverage_.inverse_depth.reset();
    if (views.empty()) return;
    int width = 1, height = 1;
    for (const Silhouettes::View& view : views) {
        width = std::max(width, (view.distance->width + 3) / 4);
        height = std::max(height, view.distance->height);
    }
    distances_.emplace(width, height, static_cast<int>(views.size()), 1);
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Distances& image = *views[i].distance;
        const std::vector<std::uint32_t> texels = packed(image);
        distances_->write(0, static_cast<int>(i), (image.width + 3) / 4, image.height, texels.data());
        work.bytes_up += std::span(texels).size_bytes();
    }
    for (const Silhouettes::View& view : views) on_device_.push_back(view.distance);
}

void DeviceSilhouettes::look(const DeviceMesh& mesh, DeviceWork& work) {
    if (n_views() > 0) depth_pass_.render(mesh, n_views(), coverage_, work);
}

void DeviceSilhouettes::bind_textures() const {
    if (n_views() == 0) return;
    distances_->bind_sampler(0);
    coverage_.inverse_depth->bind_sampler(1);
}

}  // namespace anyrate
