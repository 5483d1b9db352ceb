#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/reconstruction/photo_images.h"
#include "core/reconstruction/sampling.h"
#include "core/reconstruction/surface_view.h"
#include "gpu/depth_pass.h"
#include "gpu/device_work.h"

namespace anyrate {

/// What a shader knows of a face of the current surface (shaders/common.glsl).
struct DeviceFace {
    std::int32_t n_views = 0, steps = 1;
    float slope = 0;
    std::int32_t unused = 0;
    double area_px = 0;
};

/// The current surface on the device with its visibility: which views see which face, and what hides a part of one. The
/// rules and, but for the last bit here and there, the numbers are those of Visibility (visibility.h).
class GpuSurface {
public:
    /// @param images  must outlive it; the cameras may move between two calls of set()
    explicit GpuSurface(const PhotoImages& images);

    /// As PhotoBackend::set_surface(). @throws DeviceError
    void set(const SurfaceView& surface, int level, double samples_per_px, std::span<const std::int32_t> faces,
             Sampling sampling, DeviceWork& work);

    const GlBuffer& faces() const { return faces_; }
    const GlBuffer& sights() const { return sights_; }
    const GlBuffer& triangles() const { return triangles_; }
    const GlBuffer& corner_weights() const { return corner_weights_; }  ///< 1 / valence of each vertex
    const GlBuffer& depth_sizes() const { return depth_.sizes; }
    const GlTextureArray& inverse_depth() const { return *depth_.inverse_depth; }
    int depth_level() const { return depth_level_; }
    /// Shaders may move its vertices once set() is done: what is known of the surface stays as it was before.
    DeviceMesh mesh() const { return {vertices_, triangles_, n_vertices_, n_faces_}; }

    /// The faces as the device has them. Waits for it.
    std::vector<DeviceFace> read_faces(DeviceWork& work) const;
    /// The views that see a face of read_faces(), each as 2 view + (whole ? 1 : 0), by faces, as many as there are
    /// views for each. Waits for the device.
    std::vector<std::int32_t> read_sights(DeviceWork& work) const;

private:
    void find_sights(std::span<const std::int32_t> faces, int level, double samples_per_px, DeviceWork& work);

    const PhotoImages& images_;
    DepthPass depth_pass_;
    GlProgram find_;
    DepthMaps depth_;
    GlBuffer vertices_, triangles_, corner_weights_, asked_, sights_, faces_;
    int depth_level_ = -1;
    std::size_t n_vertices_ = 0, n_faces_ = 0;
};

}  // namespace anyrate
