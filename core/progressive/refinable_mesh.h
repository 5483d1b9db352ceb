#pragma once
// The refinement state that encoder and decoder share bit for bit: see proto/FORMAT.md, "State" and "Operation".
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/progressive/grid.h"

namespace anyrate {

/// The coarse mesh a log starts from, on the grid.
struct BaseMesh {
    std::vector<GridPoint> positions;
    std::vector<Triangle> triangles;
};

/// One refinement: split a face, move the three new vertices and the six around them along their normals.
struct SplitRecord {
    std::int32_t face = 0;
    std::array<std::int32_t, 3> residual{};  ///< new vertices on edges c0c1, c1c2, c2c0, in steps
    std::array<std::int32_t, 6> update{};    ///< corners c0 c1 c2, apexes a0 a1 a2, in steps
    friend bool operator==(const SplitRecord&, const SplitRecord&) = default;
};

/// The rules a header fixes for a whole log.
struct RefinementRules {
    int step_ratio = 80;  ///< a step is the power of two of grid units nearest to edge / step_ratio
    friend bool operator==(const RefinementRules&, const RefinementRules&) = default;
};

/// Where the operation stands when it needs the scalar of one vertex.
struct ScalarSite {
    int slot = 0;         ///< 0..2 new vertices, 3..5 corners, 6..8 apexes
    std::int32_t vertex = 0;
    Vec3 position;        ///< grid units, after the implied smoothing
    Vec3 normal;          ///< unit
    double step = 1.0;    ///< grid units
};

/// A closed manifold triangle mesh on integer positions that only grows, by splits; vertex and face numbers never die.
/// Half-edge 3f+i runs from corner i to corner i+1 of face f. Not thread-safe for writing; copies are independent.
class RefinableMesh {
public:
    /// @throws DecodeError if `base` is not a closed consistently oriented manifold, or a position leaves the grid
    RefinableMesh(const BaseMesh& base, const Grid& grid, const RefinementRules& rules);

    int n_vertices() const;
    int n_faces() const;
    const Grid& grid() const;
    std::span<const GridPoint> positions() const;
    std::span<const Triangle> triangles() const;
    std::int32_t twin(std::int32_t halfedge) const;  ///< the opposite half-edge
    int valence(std::int32_t vertex) const;

    /// The six vertices around a face that its split would move: corners c0 c1 c2, apexes a0 a1 a2;
    /// nullopt if the face cannot be split here (FORMAT.md, "Splittable": the six are not distinct, ...).
    std::optional<std::array<std::int32_t, 6>> split_site(std::int32_t face) const;

    /// Encoder: splits `face`, asking `choose` for each of the nine scalars in the order of the operation.
    /// The split_site() of the face must exist. @return the record that apply() replays to the same state
    SplitRecord split(std::int32_t face, const std::function<std::int32_t(const ScalarSite&)>& choose);
    /// Decoder: replays one record. @throws DecodeError if the face cannot be split or a vertex would leave the grid
    void apply(const SplitRecord& record);

    /// Rolling hash over every vertex write and flip since the base.
    std::uint32_t state_hash() const;

    /// The mesh in world units, without colours.
    Mesh to_mesh() const;
};

}  // namespace anyrate
