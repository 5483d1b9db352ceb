#include "gpu/gpu_surface.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numeric>
#include <string>

#include "core/reconstruction/visibility.h"
#include "gpu/photo_textures.h"
#include "gpu/shaders.h"

namespace anyrate {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

static_assert(sizeof(DeviceFace) == 24 && sizeof(Vec3) == 24 && sizeof(Triangle) == 12, "as the shaders read them");

std::string max_steps() { return "#define MAX_STEPS " + std::to_string(max_lattice_steps) + "\n"; }

}  // namespace

GpuSurface::GpuSurface(const PhotoImages& images)
    : images_(images),
      depth_pass_(camera_block_stride),
      find_("sights", shaders::with_common(shaders::sights), max_steps()) {}

void GpuSurface::set(const SurfaceView& surface, int level, double samples_per_px, std::span<const std::int32_t> faces,
                     Sampling sampling, DeviceWork& work) {
    n_vertices_ = surface.vertices.size();
    n_faces_ = surface.triangles.size();
    const OneRings rings(surface);
    std::vector<float> weights(n_vertices_);
    for (std::size_t v = 0; v < n_vertices_; ++v)
        weights[v] = 1.0F / static_cast<float>(rings.valence(static_cast<std::int32_t>(v)));
    work.write<float>(corner_weights_, weights);
    work.write<Vec3>(vertices_, surface.vertices);
    work.write<Triangle>(triangles_, surface.triangles);

    // As CpuBackend: a pixel of a coarse level asks for no finer depth than its own quarters.
    VisibilityOptions options;
    options.finest_level = std::max(level - 1, options.finest_level);
    const int depth_level = depth_map_level(images_, options.finest_level);
    if (depth_level != depth_level_) {
        int width = 1, height = 1;
        for (const PhotoView& view : images_.views) {
            width = std::max(width, view.levels[at(depth_level)].width);
            height = std::max(height, view.levels[at(depth_level)].height);
        }
        depth_.inverse_depth.reset();
        depth_.inverse_depth.emplace(width, height, images_.n_views(), 1);
        depth_level_ = depth_level;
    }
    std::vector<double> tolerances;
    for (const PhotoView& view : images_.views)
        tolerances.push_back(std::ldexp(options.tolerance_px, depth_level) / view.focal_px);
    work.write<double>(depth_.cameras, camera_block(images_, depth_level, tolerances));
    std::vector<std::int32_t> sizes = size_block(images_, depth_level);
    for (const PhotoView& view : images_.views)
        sizes.push_back(std::bit_cast<std::int32_t>(far_part(view, depth_level, options)));
    work.write<std::int32_t>(depth_.sizes, sizes);

    std::vector<std::int32_t> all;
    if (faces.empty()) {
        all.resize(n_faces_);
        std::iota(all.begin(), all.end(), 0);
        faces = all;
    }
    depth_pass_.render(mesh(), images_.views.size(), depth_, work);
    find_sights(faces, level, samples_per_px, work);
    if (sampling == Sampling::adaptive) return;
    // How many samples every face gets depends on all of them.
    std::vector<DeviceFace> found = read_faces(work);
    std::vector<double> areas_px(found.size());
    for (std::size_t f = 0; f < found.size(); ++f) areas_px[f] = std::ldexp(found[f].area_px, -2 * level);
    const std::vector<int> steps = lattice_steps(areas_px, samples_per_px, sampling);
    for (std::size_t f = 0; f < found.size(); ++f) found[f].steps = steps[f];
    work.write<DeviceFace>(faces_, found);
}

void GpuSurface::find_sights(std::span<const std::int32_t> faces, int level, double samples_per_px, DeviceWork& work) {
    const std::size_t n_views = images_.views.size();
    work.write(asked_, faces);
    sights_.reserve(sizeof(std::int32_t) * n_views * n_faces_);
    faces_.clear(sizeof(DeviceFace) * n_faces_);  // the others are seen by no view
    vertices_.bind(0);
    triangles_.bind(1);
    depth_.cameras.bind(2);
    depth_.screen.bind(3);
    depth_.sizes.bind(4);
    asked_.bind(5);
    sights_.bind(6);
    faces_.bind(7);
    depth_.inverse_depth->bind_sampler(0);
    find_.set(0, static_cast<std::int32_t>(faces.size()));
    find_.set(1, static_cast<std::int32_t>(n_vertices_));
    find_.set(2, static_cast<std::int32_t>(n_views));
    find_.set(3, std::ldexp(0.5F, 2 * depth_level_));
    find_.set(4, VisibilityOptions{}.min_cos);
    find_.set(5, std::ldexp(2.0 * samples_per_px, -2 * level));
    work.run(find_, faces.size());
}

std::vector<DeviceFace> GpuSurface::read_faces(DeviceWork& work) const {
    std::vector<DeviceFace> faces(n_faces_);
    work.read<DeviceFace>(faces_, faces);
    return faces;
}

std::vector<std::int32_t> GpuSurface::read_sights(DeviceWork& work) const {
    std::vector<std::int32_t> sights(n_faces_ * images_.views.size());
    work.read<std::int32_t>(sights_, sights);
    return sights;
}

}  // namespace anyrate
