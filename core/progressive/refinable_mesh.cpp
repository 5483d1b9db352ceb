// The operation of proto/FORMAT.md, step by step; the numbers in the comments are its headings.
// PN triangles: Vlachos, Peters, Boyd, Mitchell, "Curved PN Triangles", 2001.
#include "core/progressive/refinable_mesh.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/progressive/edge_flip.h"
#include "core/progressive/step_rule.h"

namespace anyrate {

namespace {

constexpr std::uint32_t flip_mark = 0x80000000u;
constexpr double new_vertex_smoothing = 0.5;

double weight_of(RingSmoothing smoothing) { return smoothing == RingSmoothing::quarter ? 0.25 : 0.0625; }

/// Unit vector along a ring's summed face normals; a ring without area has none, so it gets a fixed one.
LatticeVector unit_normal(const LatticeVector& sum) {
    if (sum.x == 0 && sum.y == 0 && sum.z == 0) return {0, 0, 1};
    return sum / length(sum);
}

}  // namespace

/// What the faces around a vertex say about it.
struct RefinableMesh::Ring {
    LatticeVector centroid_offset;  ///< mean of the neighbours minus the vertex
    LatticeVector normal;           ///< unit
};

RefinableMesh::RefinableMesh(const BaseMesh& base, const Grid& grid, const RefinementRules& rules)
    : grid_(grid),
      rules_(rules),
      connectivity_(static_cast<int>(base.positions.size()), base.triangles),
      positions_(base.positions) {
    if (grid.bits < 1 || grid.bits > 20) {
        throw DecodeError("grid: expected 1 to 20 bits, got " + std::to_string(grid.bits));
    }
    if (rules.step_ratio < 1 || rules.step_ratio > 65535) {
        throw DecodeError("step ratio: expected 1 to 65535, got " + std::to_string(rules.step_ratio));
    }
    for (std::size_t v = 0; v < positions_.size(); ++v) {
        const GridPoint& p = positions_[v];
        if (!on_grid(p)) {
            throw DecodeError("base vertex " + std::to_string(v) + ": position leaves the grid of " +
                              std::to_string(grid.bits) + " bits");
        }
        for (const std::int32_t word : {p.x, p.y, p.z}) hash_.mix(word);
    }
    for (const Triangle& triangle : base.triangles) {
        for (const std::int32_t v : triangle) hash_.mix(v);
    }
}

int RefinableMesh::n_vertices() const { return connectivity_.n_vertices(); }
int RefinableMesh::n_faces() const { return connectivity_.n_faces(); }
const Grid& RefinableMesh::grid() const { return grid_; }
const RefinementRules& RefinableMesh::rules() const { return rules_; }

void RefinableMesh::move_grid(const Vec3& origin, double unit) {
    grid_.origin = origin;
    grid_.unit = unit;
}
std::span<const GridPoint> RefinableMesh::positions() const { return positions_; }
std::span<const Triangle> RefinableMesh::triangles() const { return connectivity_.triangles(); }
std::int32_t RefinableMesh::twin(std::int32_t halfedge) const { return connectivity_.twin(halfedge); }
int RefinableMesh::valence(std::int32_t vertex) const { return connectivity_.valence(vertex); }
std::uint32_t RefinableMesh::state_hash() const { return hash_.value(); }

std::optional<std::array<std::int32_t, 6>> RefinableMesh::split_site(std::int32_t face) const {
    return connectivity_.split_site(face);
}

SplitRecord RefinableMesh::split(std::int32_t face, const std::function<std::int32_t(const ScalarSite&)>& choose) {
    const auto site = split_site(face);
    if (!site) throw InputError("split: face " + std::to_string(face) + " cannot be split");
    SplitRecord record{.face = face};
    refine(face, *site, [&](int slot, std::int32_t vertex, std::int32_t step, const auto& normal_of) {
        const LatticeVector normal = normal_of(vertex), position = at(vertex);
        std::int32_t scalar = choose({.slot = slot,
                                      .vertex = vertex,
                                      .position = {position.x, position.y, position.z},
                                      .normal = {normal.x, normal.y, normal.z},
                                      .step = static_cast<double>(step)});
        while (!on_grid(moved(vertex, scalar, step, normal))) scalar /= 2;
        (slot < 3 ? record.residual[static_cast<std::size_t>(slot)]
                  : record.update[static_cast<std::size_t>(slot - 3)]) = scalar;
        return scalar;
    });
    return record;
}

void RefinableMesh::apply(const SplitRecord& record) {
    const auto site = split_site(record.face);
    if (!site) throw DecodeError("face " + std::to_string(record.face) + " cannot be split");
    refine(record.face, *site, [&](int slot, std::int32_t, std::int32_t, const auto&) {
        return slot < 3 ? record.residual[static_cast<std::size_t>(slot)]
                        : record.update[static_cast<std::size_t>(slot - 3)];
    });
}

/// The one path of encoder and decoder. `choose(slot, vertex, step, normal_of)` gives the scalar of a vertex; the
/// normal is a function because a decoder that reads 0 does not need it.
template <class ChooseScalar>
void RefinableMesh::refine(std::int32_t face, const std::array<std::int32_t, 6>& site, ChooseScalar&& choose) {
    const std::int32_t V = n_vertices(), F = n_faces();
    const RollingHash hash_before = hash_;
    const auto point = [this](std::int32_t v) { return positions_[static_cast<std::size_t>(v)]; };
    const std::int32_t step = scalar_step(point(site[0]), point(site[1]), point(site[2]), rules_.step_ratio);
    const auto move = [&](int slot, std::int32_t vertex, const auto& normal_of) {
        const std::int32_t scalar = choose(slot, vertex, step, normal_of);
        const GridPoint to = scalar == 0 ? point(vertex) : moved(vertex, scalar, step, normal_of(vertex));
        if (!on_grid(to)) {
            throw DecodeError("split of face " + std::to_string(face) + ": scalar " + std::to_string(scalar) +
                              " takes vertex " + std::to_string(vertex) + " off the grid");
        }
        write(vertex, to);
    };

    positions_.resize(positions_.size() + 3);
    try {
        hash_.mix(face);
        const Corners corners = {at(site[0]), at(site[1]), at(site[2])};
        const Corners corner_normals = {ring(site[0]).normal, ring(site[1]).normal, ring(site[2]).normal};
        const auto metric =
            rules_.flip_rule == FlipRule::curvature_aligned ? curvature_metric(corners, corner_normals) : std::nullopt;
        predict(corners, corner_normals);       // 1
        connectivity_.split(face, site);        // 2
        for (int pass = 0; pass < 2; ++pass) {  // 3
            for (std::int32_t i = 0; i < 3; ++i) flip_around(V + i, metric ? &*metric : nullptr);
        }
        for (std::int32_t i = 0; i < 3; ++i) smooth(V + i, new_vertex_smoothing);  // 4

        const std::array<LatticeVector, 3> normals = {ring(V).normal, ring(V + 1).normal, ring(V + 2).normal};  // 5
        const auto new_normal = [&](std::int32_t v) { return normals[static_cast<std::size_t>(v - V)]; };
        for (std::int32_t i = 0; i < 3; ++i) move(i, V + i, new_normal);

        const auto ring_normal = [this](std::int32_t v) { return ring(v).normal; };
        const double ring_weight = weight_of(rules_.ring_smoothing);
        for (int i = 0; i < 6; ++i) {  // 6
            smooth(site[static_cast<std::size_t>(i)], ring_weight);
            move(3 + i, site[static_cast<std::size_t>(i)], ring_normal);
        }
    } catch (...) {
        moves_.undo();
        positions_.resize(static_cast<std::size_t>(V));
        connectivity_.roll_back(V, F);
        hash_ = hash_before;
        throw;
    }
    moves_.clear();
    connectivity_.commit();
}

void RefinableMesh::predict(const Corners& corners, const Corners& normals) {
    const std::int32_t V = n_vertices();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const LatticeVector p = corners[i], q = corners[j], e = q - p;
        const LatticeVector bulge = dot(e, normals[i]) * normals[i] - dot(e, normals[j]) * normals[j];
        write(V + static_cast<std::int32_t>(i), clamped_to_grid(0.5 * (p + q) - 0.125 * bulge));
    }
}

void RefinableMesh::flip_around(std::int32_t vertex, const CurvatureMetric* metric) {
    const std::int32_t first = connectivity_.outgoing(vertex);
    std::int32_t spoke = first;
    do {
        const std::int32_t link = HalfedgeConnectivity::next(spoke);
        if (flips(link, metric)) {
            connectivity_.flip(link);
            hash_.mix(flip_mark + static_cast<std::uint32_t>(link));
        }
        spoke = connectivity_.next_spoke(spoke);
    } while (spoke != first);
}

bool RefinableMesh::flips(std::int32_t halfedge, const CurvatureMetric* metric) const {
    const std::int32_t opposite = twin(halfedge);
    const EdgeQuad quad = {.p = at(connectivity_.origin(halfedge)),
                           .q = at(connectivity_.origin(opposite)),
                           .m = at(connectivity_.origin(HalfedgeConnectivity::prev(halfedge))),
                           .s = at(connectivity_.origin(HalfedgeConnectivity::prev(opposite)))};
    return wants_flip(quad, rules_.flip_rule, metric) && connectivity_.can_flip(halfedge);
}

RefinableMesh::Ring RefinableMesh::ring(std::int32_t vertex) const {
    const LatticeVector centre = at(vertex);
    const std::int32_t first = connectivity_.outgoing(vertex);
    LatticeVector normals, offsets;
    LatticeVector here = at(connectivity_.target(first)) - centre;
    std::int32_t spoke = first;
    do {  // sums of integers below 2^53: exact, so the order of the ring does not matter
        spoke = connectivity_.next_spoke(spoke);
        const LatticeVector there = at(connectivity_.target(spoke)) - centre;
        normals = normals + cross(here, there);
        offsets = offsets + there;
        here = there;
    } while (spoke != first);
    const double n = connectivity_.valence(vertex);
    return {(offsets + n * centre) / n - centre, unit_normal(normals)};
}

void RefinableMesh::smooth(std::int32_t vertex, double weight) {
    const Ring around = ring(vertex);
    const LatticeVector tangential =
        around.centroid_offset - dot(around.centroid_offset, around.normal) * around.normal;
    write(vertex, clamped_to_grid(at(vertex) + weight * tangential));
}

GridPoint RefinableMesh::moved(std::int32_t vertex, std::int32_t scalar, std::int32_t step,
                               const LatticeVector& normal) const {
    const double distance = static_cast<double>(scalar) * static_cast<double>(step);
    const LatticeVector to = at(vertex) + distance * normal;
    const double limit = static_cast<double>(std::int32_t{1} << grid_.bits);
    const auto coordinate = [limit](double x) {  // -1 stands for all that lies outside
        const double rounded = round_half_up(x);
        return rounded >= 0 && rounded < limit ? static_cast<std::int32_t>(rounded) : -1;
    };
    return {coordinate(to.x), coordinate(to.y), coordinate(to.z)};
}

bool RefinableMesh::on_grid(const GridPoint& p) const {
    const std::int32_t limit = std::int32_t{1} << grid_.bits;
    const auto inside = [limit](std::int32_t x) { return x >= 0 && x < limit; };
    return inside(p.x) && inside(p.y) && inside(p.z);
}

GridPoint RefinableMesh::clamped_to_grid(const LatticeVector& p) const {
    const double largest = static_cast<double>((std::int32_t{1} << grid_.bits) - 1);
    const auto coordinate = [largest](double x) {
        return static_cast<std::int32_t>(std::clamp(round_half_up(x), 0.0, largest));
    };
    return {coordinate(p.x), coordinate(p.y), coordinate(p.z)};
}

void RefinableMesh::write(std::int32_t vertex, const GridPoint& p) {
    GridPoint& slot = positions_[static_cast<std::size_t>(vertex)];
    moves_.set(slot.x, p.x);
    moves_.set(slot.y, p.y);
    moves_.set(slot.z, p.z);
    for (const std::int32_t word : {vertex, p.x, p.y, p.z}) hash_.mix(word);
}

Mesh RefinableMesh::to_mesh() const {
    Mesh mesh;
    mesh.vertices.reserve(positions_.size());
    for (const GridPoint& p : positions_) mesh.vertices.push_back(grid_.to_world(p));
    mesh.triangles.assign(triangles().begin(), triangles().end());
    return mesh;
}

}  // namespace anyrate
