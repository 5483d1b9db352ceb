#pragma once
// Who touches whom in the refinement state, without positions: proto/FORMAT.md, "State", "Split" and "Flip".
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/progressive/undo_journal.h"
#include "core/types.h"

namespace anyrate {

/// No vertex grows beyond this many edges by a split or flip, so that the work of one operation is bounded.
inline constexpr int max_valence = 64;
/// Bound on the vertices of a log; half-edge numbers stay far below 2^31.
inline constexpr int max_log_vertices = 1 << 24;

/// A closed, oriented, manifold triangle mesh as plain arrays: half-edge 3f+i runs from corner i of face f to corner
/// i+1. Every change is atomic for the caller that ends it by commit() or roll_back().
class HalfedgeConnectivity {
public:
    /// @throws DecodeError if the triangles do not form closed, consistently oriented, manifold fans of valence >= 3
    /// around
    ///         each of the n_vertices vertices
    HalfedgeConnectivity(int n_vertices, std::span<const Triangle> triangles);

    int n_vertices() const { return static_cast<int>(outgoing_.size()); }
    int n_faces() const { return static_cast<int>(triangles_.size()); }
    std::span<const Triangle> triangles() const { return triangles_; }

    static std::int32_t next(std::int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::int32_t prev(std::int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    std::int32_t twin(std::int32_t h) const { return twin_[index(h)]; }
    std::int32_t origin(std::int32_t h) const { return triangles_[index(h / 3)][index(h % 3)]; }
    std::int32_t target(std::int32_t h) const { return origin(next(h)); }
    /// The next spoke, counter-clockwise, around the origin of h.
    std::int32_t next_spoke(std::int32_t h) const { return twin(prev(h)); }
    std::int32_t outgoing(std::int32_t vertex) const { return outgoing_[index(vertex)]; }
    int valence(std::int32_t vertex) const { return valence_[index(vertex)]; }
    bool are_neighbours(std::int32_t a, std::int32_t b) const;

    /// Corners c0 c1 c2 and apexes a0 a1 a2 of a face; nullopt if it cannot be split (FORMAT.md, "Splittable").
    std::optional<std::array<std::int32_t, 6>> split_site(std::int32_t face) const;
    /// Splits a face that has a split_site(): adds three vertices and six faces.
    void split(std::int32_t face, const std::array<std::int32_t, 6>& site);
    /// Whether the connectivity allows to replace the edge of h by the one between the two opposite corners.
    bool can_flip(std::int32_t h) const;
    void flip(std::int32_t h);

    void commit() { journal_.clear(); }
    /// Undoes everything since the last commit, back to so many vertices and faces.
    void roll_back(int n_vertices, int n_faces);

private:
    static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
    void match_twins();
    void check_fans() const;
    void set_origin(std::int32_t h, std::int32_t vertex) {
        journal_.set(triangles_[index(h / 3)][index(h % 3)], vertex);
    }
    void link(std::int32_t h, std::int32_t t) {
        journal_.set(twin_[index(h)], t);
        journal_.set(twin_[index(t)], h);
    }
    void add_valence(std::int32_t vertex, int change) {
        journal_.set(valence_[index(vertex)], valence_[index(vertex)] + change);
    }

    std::vector<Triangle> triangles_;
    std::vector<std::int32_t> twin_;
    std::vector<std::int32_t> outgoing_;
    std::vector<std::int32_t> valence_;
    UndoJournal journal_;
};

}  // namespace anyrate
