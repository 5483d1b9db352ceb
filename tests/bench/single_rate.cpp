// What a mesh takes in Draco at a single rate (edgebreaker, level 10): the yardstick of tests/bench/rate_distortion.py.
//
// usage: single_rate MESH --model MODEL.arl      on the grid of a model, on which its decoded meshes lie exactly
//        single_rate MESH --bits B [-o OUT]      on a grid of B bits around it; OUT is the mesh as it arrives
// prints {"vertices", "bytes": of the Draco string}
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "core/mesh/bounds.h"
#include "core/mesh/mesh_io.h"
#include "core/progressive/base_on_grid.h"
#include "proto/draco_io.h"
#include "proto/log_reader.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;

/// The coarsest grid of so many bits that holds the mesh.
Grid grid_around(const Mesh& mesh, int bits) {
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    return {.origin = box.min(),
            .unit = box.sizes().maxCoeff() / (std::ldexp(1.0, bits) - 1),
            .bits = bits,
            .base_shift = 0};
}

Grid grid_of(const std::string& model) {
    std::ifstream file(model, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file) throw InputError(model + ": cannot be read");
    Grid grid = read_layout(std::as_bytes(std::span(bytes))).header.grid;
    grid.base_shift = 0;
    return grid;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Tells the bytes of a mesh in single-rate Draco.");
    std::string input, model, output;
    int bits = 14;
    app.add_option("MESH", input, "mesh (.ply or .obj)")->required();
    auto* of_model = app.add_option("--model", model, "whose grid is taken");
    app.add_option("--bits", bits, "of a grid around the mesh")->check(CLI::Range(1, 20))->excludes(of_model);
    app.add_option("-o,--output", output, "the mesh with its vertices on the grid");
    return bench::run_tool(app, argc, argv, [&]() -> bench::Json {
        Mesh mesh = read_mesh(input);
        const Grid grid = model.empty() ? grid_around(mesh, bits) : grid_of(model);
        const BaseMesh on_grid = nearest_base(mesh, grid);
        mesh.colours.clear();
        std::ranges::transform(on_grid.positions, mesh.vertices.begin(),
                               [&](const GridPoint& p) { return grid.to_world(p); });
        if (!output.empty()) write_mesh(mesh, output);
        return {{"vertices", mesh.n_vertices()}, {"bytes", encode_draco_mesh(on_grid).size()}};
    });
}
