#include "core/reconstruction/flow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/reconstruction/mean_curvature.h"
#include "core/reconstruction/tangential.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

std::vector<double> shortest_edges(const SurfaceView& surface, const OneRings& rings) {
    std::vector<double> shortest(surface.vertices.size(), std::numeric_limits<double>::infinity());
    for (std::size_t v = 0; v < shortest.size(); ++v)
        for (std::int32_t w : rings.neighbours(static_cast<std::int32_t>(v)))
            shortest[v] = std::min(shortest[v], (surface.vertices[at(w)] - surface.vertices[v]).norm());
    return shortest;
}

}  // namespace

std::vector<std::optional<double>> normal_gradient(PhotoBackend& backend, const SurfaceView& surface,
                                                   const OneRings& rings, std::span<const Vec3> normals,
                                                   std::span<const double> half_width) {
    std::vector<TriangleQuery> batch;
    batch.reserve(6 * surface.triangles.size());
    for (std::size_t v = 0; v < surface.vertices.size(); ++v)
        for (double sign : {1.0, -1.0})
            for (std::int32_t f : rings.faces(static_cast<std::int32_t>(v))) {
                TriangleQuery& query = batch.emplace_back();
                query.face = f;
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::size_t w = at(surface.triangles[at(f)][k]);
                    query.corners[k] = surface.vertices[w];
                    if (w == v) query.corners[k] += sign * half_width[v] * normals[v];
                }
            }
    const std::vector<TriangleDistortion> distortions = backend.distortions(batch);

    std::vector<std::optional<double>> gradient(surface.vertices.size());
    std::size_t next = 0;
    for (std::size_t v = 0; v < gradient.size(); ++v) {
        TriangleDistortion end[2];
        for (TriangleDistortion& ring : end)
            for (std::size_t k = 0; k < rings.faces(static_cast<std::int32_t>(v)).size(); ++k, ++next) {
                ring.phi += distortions[next].phi;
                ring.n_samples += distortions[next].n_samples;
            }
        // Nghiem et al., Eq. 11: central difference; the ring is resampled at both ends, not interpolated.
        if (end[0].n_samples > 0 && end[1].n_samples > 0)
            gradient[v] = (end[0].phi / end[0].n_samples - end[1].phi / end[1].n_samples) / (2 * half_width[v]);
    }
    return gradient;
}

std::vector<Vec3> flow_step(std::span<const std::optional<double>> G, std::span<const std::optional<double>> gradient,
                            std::span<const Vec3> curvature_normals, std::span<const Vec3> normals,
                            std::span<const double> bounds) {
    std::vector<double> speed(normals.size());
    std::vector<double> time_steps;
    for (std::size_t v = 0; v < speed.size(); ++v) {
        // Nghiem et al., Eq. 3. The curvature normal points to where the surface shrinks, so its component enters with
        // its own sign and the gradient with the opposite one: both terms lower the energy.
        speed[v] = G[v].value_or(0.0) * curvature_normals[v].dot(normals[v]) - gradient[v].value_or(0.0);
        if (speed[v] != 0) time_steps.push_back(bounds[v] / std::abs(speed[v]));
    }
    std::vector<Vec3> displacement(speed.size(), Vec3::Zero());
    if (time_steps.empty()) return displacement;
    const auto tenth = time_steps.begin() + static_cast<std::ptrdiff_t>(time_steps.size() / 10);
    std::nth_element(time_steps.begin(), tenth, time_steps.end());
    const double dt = *tenth;
    // Nghiem et al., Eq. 4.
    for (std::size_t v = 0; v < speed.size(); ++v)
        displacement[v] = std::clamp(speed[v] * dt, -bounds[v], bounds[v]) * normals[v];
    return displacement;
}

void surface_flow(PhotoBackend& backend, std::vector<Vec3>& vertices, std::span<const Triangle> triangles,
                  const FlowOptions& options, const std::function<void(int, double)>& progress,
                  const std::stop_token& stop) {
    const OneRings rings({vertices, triangles});
    std::vector<Vec3> best = vertices;
    double lowest = std::numeric_limits<double>::infinity();
    double courant = options.courant;
    for (int iteration = 0, worse = 0; iteration <= options.max_iterations && !stop.stop_requested(); ++iteration) {
        const SurfaceView surface(vertices, triangles);
        backend.set_surface(surface, 0, options.samples_per_px);
        const std::vector<TriangleDistortion> phi = backend.distortions(whole_surface(surface));
        const double psi = surface_distortion(phi);
        if (progress) progress(iteration, psi);
        if (psi < lowest) {
            lowest = psi;
            best = vertices;
            worse = 0;
        } else if (++worse == options.patience) {
            break;
        } else {
            courant /= 2;
        }
        const auto G = vertex_distortion(rings, surface.n_vertices(), phi);
        const std::vector<Vec3> normals = vertex_normals(surface, rings);
        std::vector<double> half_width = shortest_edges(surface, rings);
        std::vector<double> bounds(half_width);
        for (double& w : half_width) w *= options.eta;
        for (double& b : bounds) b *= courant;
        const auto gradient = normal_gradient(backend, surface, rings, normals, half_width);
        const std::vector<Vec3> step = flow_step(G, gradient, mean_curvature_normals(surface, rings), normals, bounds);
        std::vector<Vec3> moved(vertices);
        for (std::size_t v = 0; v < moved.size(); ++v)
            moved[v] += step[v] + options.tangential *
                                      tangential_laplacian(surface, rings, normals[v], static_cast<std::int32_t>(v));
        vertices = std::move(moved);
    }
    vertices = best;
}

}  // namespace anyrate
