#pragma once
// Small models built in code, for the tests of the stream and for its golden files. Only + - * / sqrt and integers are
// used, so that every machine builds the same bytes.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/progressive/model_sink.h"
#include "core/progressive/refinable_mesh.h"
#include "proto/index.h"

namespace anyrate::samples {

/// A log and all that its decoder must find.
struct SampleLog {
    std::vector<std::byte> live;  ///< with end frame
    std::vector<IndexRow> rows;
    std::vector<std::uint32_t> hash_at;  ///< state hash after 0, 1, 2, .. splits
    RefinableMesh state;                 ///< the encoder's, at the end
    std::vector<Rgb8> wished_colours;    ///< what the encoder was asked to code, one per vertex
};

struct SampleOptions {
    int n_batches = 1;
    int splits_per_batch = 2;
    bool colours = true;
    std::uint64_t log_id = 0x0123456789ABCDEF;
    RefinementRules rules = {};
};

/// A grid of `bits` bits in [-1, 1]^3, whose base positions stand on every 4th point.
Grid unit_grid(int bits);
/// The 6 unit vectors, 8 faces.
BaseMesh octahedron(const Grid& grid);
/// An icosahedron, each face split into 4 so many times, on the sphere of radius 0.75.
BaseMesh icosphere(const Grid& grid, int n_subdivisions);
/// The cube [-0.5, 0.5]^3 with flat, evenly divided sides.
BaseMesh flat_cube(const Grid& grid, int n_subdivisions);
/// A closed ring of square cross-section: genus 1.
BaseMesh square_torus(const Grid& grid);

/// Refines `base` by its longest-edged faces towards a bumpy sphere and writes the log as it goes.
SampleLog make_log(const Grid& grid, const BaseMesh& base, const SampleOptions& options);

/// The scalar that brings a vertex nearest to the bumpy sphere: what make_log() chooses.
std::int32_t towards_bumpy_sphere(const Grid& grid, const ScalarSite& site);

/// The rules of the first logs: every value 1.
RefinementRules first_rules();

/// The models of the golden files: the first two with the first rules, the cube with flip rule 2, the sphere with the
/// rules of today.
SampleLog octahedron_log();
SampleLog icosphere_log();
SampleLog cube_log();
SampleLog sphere_log();

}  // namespace anyrate::samples
