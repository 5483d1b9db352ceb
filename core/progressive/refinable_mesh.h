#pragma once
// The refinement state that encoder and decoder share bit for bit: see proto/FORMAT.md, "State" and "Operation".
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/progressive/curvature_metric.h"
#include "core/progressive/grid.h"
#include "core/progressive/halfedge_connectivity.h"
#include "core/progressive/lattice_arithmetic.h"
#include "core/progressive/refinement_rules.h"
#include "core/progressive/state_hash.h"

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

/// Where the operation stands when it needs the scalar of one vertex.
struct ScalarSite {
    int slot = 0;  ///< 0..2 new vertices, 3..5 corners, 6..8 apexes
    std::int32_t vertex = 0;
    Vec3 position;      ///< grid units, after the implied smoothing
    Vec3 normal;        ///< unit
    double step = 1.0;  ///< grid units
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
    const RefinementRules& rules() const;
    /// Has the grid stand elsewhere in the world, or at another scale: no integer changes.
    void move_grid(const Vec3& origin, double unit);
    std::span<const GridPoint> positions() const;
    std::span<const Triangle> triangles() const;
    std::int32_t twin(std::int32_t halfedge) const;  ///< the opposite half-edge
    int valence(std::int32_t vertex) const;

    /// The six vertices around a face that its split would move: corners c0 c1 c2, apexes a0 a1 a2;
    /// nullopt if the face cannot be split here (FORMAT.md, "Splittable": the six are not distinct, ...).
    std::optional<std::array<std::int32_t, 6>> split_site(std::int32_t face) const;

    /// Encoder: splits `face`, asking `choose` for each of the nine scalars in the order of the operation.
    /// The split_site() of the face must exist. A scalar that would take its vertex off the grid is reduced towards
    /// zero until it does not. @return the record that apply() replays to the same state
    /// @throws InputError if the face cannot be split; what `choose` throws: the mesh is then as before
    SplitRecord split(std::int32_t face, const std::function<std::int32_t(const ScalarSite&)>& choose);
    /// Decoder: replays one record. @throws DecodeError if the face cannot be split or a vertex would leave the grid:
    /// the mesh is then as before
    void apply(const SplitRecord& record);

    /// Rolling hash over the base and every split, vertex write and flip since (FORMAT.md, "State hash").
    std::uint32_t state_hash() const;

    /// The mesh in world units, without colours.
    Mesh to_mesh() const;

private:
    struct Ring;
    template <class ChooseScalar>
    void refine(std::int32_t face, const std::array<std::int32_t, 6>& site, ChooseScalar&& choose);
    using Corners = std::array<LatticeVector, 3>;
    void predict(const Corners& corners, const Corners& normals);
    void flip_around(std::int32_t vertex, const CurvatureMetric* metric);
    bool flips(std::int32_t halfedge, const CurvatureMetric* metric) const;
    Ring ring(std::int32_t vertex) const;
    void smooth(std::int32_t vertex, double weight);
    GridPoint moved(std::int32_t vertex, std::int32_t scalar, std::int32_t step, const LatticeVector& normal) const;
    bool on_grid(const GridPoint& p) const;
    GridPoint clamped_to_grid(const LatticeVector& p) const;
    void write(std::int32_t vertex, const GridPoint& p);
    LatticeVector at(std::int32_t vertex) const { return lattice_vector(positions_[static_cast<std::size_t>(vertex)]); }

    Grid grid_;
    RefinementRules rules_;
    HalfedgeConnectivity connectivity_;
    std::vector<GridPoint> positions_;
    UndoJournal moves_;
    RollingHash hash_;
};

}  // namespace anyrate
