#include "core/simulation/simulate.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/mesh/normals.h"
#include "core/mesh/topology.h"
#include "core/parallel.h"
#include "core/simulation/hash.h"
#include "core/simulation/parametric_meshes.h"
#include "core/simulation/polygonize.h"
#include "core/simulation/render.h"
#include "core/simulation/ring_cameras.h"
#include "core/simulation/solid_texture.h"
#include "core/simulation/vessel_paint.h"
#include "core/simulation/vessel_shape.h"

namespace anyrate {
namespace {

/// Where a solid stands in the world: upright, scaled and moved.
struct Placement {
    double scale = 1;
    Vec3 origin = Vec3::Zero();

    Vec3 world_from_solid(const Vec3& point) const { return scale * point + origin; }
    Vec3 solid_from_world(const Vec3& point) const { return (point - origin) / scale; }
};

/// The photographed object: its surface in world coordinates under a texture that knows the solid's own, which have
/// size about one.
Model textured(Mesh surface_in_world, SolidTexture texture, const Placement& placement) {
    Model model{.surface = std::move(surface_in_world), .normals = {}, .appearance = {}};
    model.normals = vertex_normals(model.surface);
    model.appearance = [placement, texture = std::move(texture)](const Vec3& point, const Vec3& normal) -> Vec3 {
        return texture(placement.solid_from_world(point)) * studio_light(normal);
    };
    return model;
}

Mesh moved(Mesh solid, const Placement& placement) {
    for (Vec3& vertex : solid.vertices) vertex = placement.world_from_solid(vertex);
    return solid;
}

/// Millimetres on a shelf: neither the size nor the place may matter to a reconstruction.
Model vessel_scene() {
    const Placement placement{.scale = 155.0, .origin = {1240.0, -530.0, 905.0}};
    Mesh vessel = polygonize(vessel_field, {.low = {-0.86, -0.74, -1.08}, .high = {0.86, 0.74, 1.08}, .cell = 0.0215});
    return textured(moved(std::move(vessel), placement), vessel_paint(2), placement);
}

Model dish_scene() {
    const Placement placement{.scale = 0.12, .origin = {0.4, 0.1, -0.2}};
    Mesh dish = polygonize(dish_field, {.low = {-1.2, -1.2, -0.8}, .high = {1.2, 1.2, 0.6}, .cell = 0.034});
    return textured(moved(std::move(dish), placement), veined_stone(3), placement);
}

Model sphere_scene() { return textured(icosphere(5), veined_stone(4), {}); }

Model torus_scene() { return textured(torus(0.75, 0.30, 240, 96), veined_stone(5), {}); }

struct NamedScene {
    std::string_view name;
    Model (*make)();
};
constexpr std::array<NamedScene, 4> scenes{
    {{"vessel", vessel_scene}, {"dish", dish_scene}, {"sphere", sphere_scene}, {"torus", torus_scene}}};

void check(const SimulateOptions& options) {
    const auto require = [](bool holds, const std::string& sentence) {
        if (!holds) throw InputError("simulation: " + sentence);
    };
    require(options.n_views >= 3, "expected at least 3 views, got " + std::to_string(options.n_views));
    require(options.width >= 16 && options.height >= 16, "expected images of at least 16x16 pixels, got " +
                                                             std::to_string(options.width) + "x" +
                                                             std::to_string(options.height));
    require(options.noise >= 0, "expected noise of at least 0, got " + std::to_string(options.noise));
    require(options.supersampling >= 1 && options.supersampling <= 16,
            "expected a supersampling of 1 to 16, got " + std::to_string(options.supersampling));
}

std::string image_name(int view) {
    std::array<char, 32> name;
    std::snprintf(name.data(), name.size(), "%03d.png", view);
    return name.data();
}

Simulation photograph(std::string name, Model model, const SimulateOptions& options) {
    const auto cameras = ring_cameras(
        model.surface.vertices,
        {.n_views = options.n_views, .width = options.width, .height = options.height, .seed = options.seed});
    Simulation simulation;
    simulation.capture.name = std::move(name);
    for (int k = 0; k < options.n_views; ++k) {
        const RenderOptions exposure{.supersampling = options.supersampling,
                                     .noise = options.noise,
                                     .seed = hash(options.seed, static_cast<std::uint64_t>(k))};
        simulation.capture.views.push_back(
            render_view(model, cameras[static_cast<std::size_t>(k)], image_name(k), exposure));
    }
    auto& colours = model.surface.colours;
    colours.resize(model.surface.vertices.size());
    parallel_for(colours.size(), [&](std::size_t v) {
        const Vec3 light = model.appearance(model.surface.vertices[v], model.normals[v]);
        colours[v] = {to_level(light.x()), to_level(light.y()), to_level(light.z())};
    });
    simulation.ground_truth = std::move(model.surface);
    return simulation;
}

/// The place of a solid of size one that fills the mesh's bounding box.
Placement placement_of(const Mesh& mesh) {
    Vec3 low = mesh.vertices.front(), high = low;
    for (const Vec3& vertex : mesh.vertices) {
        low = low.cwiseMin(vertex);
        high = high.cwiseMax(vertex);
    }
    return {.scale = 0.5 * (high - low).norm(), .origin = 0.5 * (low + high)};
}

}  // namespace

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const NamedScene& scene : scenes) names.emplace_back(scene.name);
    return names;
}

Simulation simulate_scene(std::string_view scene, const SimulateOptions& options) {
    check(options);
    const auto named = std::find_if(scenes.begin(), scenes.end(), [&](const auto& s) { return s.name == scene; });
    if (named == scenes.end()) {
        std::string known;
        for (const std::string& name : scene_names()) known += (known.empty() ? "" : ", ") + name;
        throw InputError("simulation: unknown scene '" + std::string(scene) + "', expected one of " + known);
    }
    return photograph(std::string(scene), named->make(), options);
}

Simulation simulate_mesh(const Mesh& mesh, const SimulateOptions& options) {
    check(options);
    const Topology topology = measure_topology(mesh);
    if (topology.n_faces == 0 || topology.n_boundary_edges > 0 || topology.n_inconsistent_edges > 0) {
        throw InputError("simulation: expected a closed mesh of consistent winding, got " +
                         std::to_string(topology.n_faces) + " triangles with " +
                         std::to_string(topology.n_boundary_edges) + " open and " +
                         std::to_string(topology.n_inconsistent_edges) + " inconsistent edges");
    }
    return photograph("mesh", textured(mesh, veined_stone(6), placement_of(mesh)), options);
}

}  // namespace anyrate
