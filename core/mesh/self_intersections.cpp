#include "core/mesh/self_intersections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/mesh/bounds.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

constexpr double steps_per_extent = 1 << 26;
constexpr int max_cells_per_axis = 128;  // a face as large as the mesh is then entered 128^3 times at worst

__extension__ using Wide = __int128;  // a determinant of differences of 27 bits has 84

using Point = std::array<std::int64_t, 3>;
using Corners = std::array<Point, 3>;
using FacePair = std::pair<std::int32_t, std::int32_t>;

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Point cross(const Point& a, const Point& b) {  // of differences: 55 bits
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Wide dot(const Point& a, const Point& b) {
    return static_cast<Wide>(a[0]) * b[0] + static_cast<Wide>(a[1]) * b[1] + static_cast<Wide>(a[2]) * b[2];
}

int sign(Wide x) { return (x > 0) - (x < 0); }

/// On which side of the plane of a, b, c the point d lies; 0 on it.
int side(const Point& a, const Point& b, const Point& c, const Point& d) {
    return sign(dot(cross(b - a, c - a), d - a));
}

Point normal(const Corners& t) { return cross(t[1] - t[0], t[2] - t[0]); }

bool has_area(const Corners& t) { return normal(t) != Point{0, 0, 0}; }

/// The same for three points of a plane that is looked at along the axis `drop`.
int side_in_plane(const Point& a, const Point& b, const Point& c, int drop) {
    const auto x = static_cast<std::size_t>((drop + 1) % 3), y = static_cast<std::size_t>((drop + 2) % 3);
    const Point u = b - a, v = c - a;
    return sign(static_cast<Wide>(u[x]) * v[y] - static_cast<Wide>(u[y]) * v[x]);
}

/// Whether the segments pq and ab of one plane meet, ends included. Parallel ones that overlap are found by their ends
/// lying in the triangle.
bool cross_in_plane(const Point& p, const Point& q, const Point& a, const Point& b, int drop) {
    const int pa = side_in_plane(p, q, a, drop), pb = side_in_plane(p, q, b, drop);
    const int ap = side_in_plane(a, b, p, drop), aq = side_in_plane(a, b, q, drop);
    return pa * pb <= 0 && ap * aq <= 0 && (pa != 0 || pb != 0);
}

bool lies_in(const Point& p, const Corners& t, int drop) {
    int least = 1, most = -1;
    for (std::size_t i = 0; i < 3; ++i) {
        const int s = side_in_plane(t[i], t[(i + 1) % 3], p, drop);
        least = std::min(least, s);
        most = std::max(most, s);
    }
    return least >= 0 || most <= 0;
}

bool segment_meets_coplanar(const Point& p, const Point& q, const Corners& t) {
    const Point n = normal(t);
    int drop = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (std::abs(n[static_cast<std::size_t>(axis)]) > std::abs(n[static_cast<std::size_t>(drop)])) drop = axis;
    if (lies_in(p, t, drop) || lies_in(q, t, drop)) return true;
    for (std::size_t i = 0; i < 3; ++i)
        if (cross_in_plane(p, q, t[i], t[(i + 1) % 3], drop)) return true;
    return false;
}

bool segment_meets(const Point& p, const Point& q, const Corners& t) {
    const int at_p = side(t[0], t[1], t[2], p), at_q = side(t[0], t[1], t[2], q);
    if (at_p == 0 && at_q == 0) return segment_meets_coplanar(p, q, t);
    if (at_p * at_q > 0) return false;
    int least = 1, most = -1;
    for (std::size_t i = 0; i < 3; ++i) {
        const int s = side(p, q, t[i], t[(i + 1) % 3]);
        least = std::min(least, s);
        most = std::max(most, s);
    }
    return least >= 0 || most <= 0;
}

bool disjoint_faces_meet(const Corners& a, const Corners& b) {
    for (std::size_t i = 0; i < 3; ++i)
        if (segment_meets(a[i], a[(i + 1) % 3], b) || segment_meets(b[i], b[(i + 1) % 3], a)) return true;
    return false;
}

/// Two faces that share corner i of a and corner j of b. What else they share ends on the edge opposite of one of them.
bool corner_neighbours_meet(const Corners& a, std::size_t i, const Corners& b, std::size_t j) {
    return segment_meets(a[(i + 1) % 3], a[(i + 2) % 3], b) || segment_meets(b[(j + 1) % 3], b[(j + 2) % 3], a);
}

/// Two faces with an edge in common meet elsewhere only if they lie in one plane, on the same side of the edge. i and j
/// are the corners opposite of it.
bool edge_neighbours_meet(const Corners& a, std::size_t i, const Corners& b, std::size_t j) {
    const Point &p = a[(i + 1) % 3], &q = a[(i + 2) % 3];
    if (side(p, q, a[i], b[j]) != 0) return false;
    return dot(cross(q - p, a[i] - p), cross(q - p, b[j] - p)) > 0;
}

/// The faces on the grid, and the cells that they are sorted into.
class Scene {
public:
    explicit Scene(const Mesh& mesh) : mesh_(mesh), corners_(mesh.triangles.size()), box_(mesh.triangles.size()) {
        const Eigen::AlignedBox3d box = bounding_box(mesh);
        const double extent = std::max(box.sizes().maxCoeff(), 1e-300);
        parallel_for(corners_.size(), [&](std::size_t f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 steps = (mesh.vertices[static_cast<std::size_t>(mesh.triangles[f][k])] - box.min()) *
                                   (steps_per_extent / extent);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    corners_[f][k][axis] = std::llround(steps[static_cast<Eigen::Index>(axis)]);
            }
            box_[f] = bounds(corners_[f]);
        });
        choose_cells();
    }

    std::vector<FacePair> meeting_pairs() const {
        const std::vector<Entry> entries = sorted_entries();
        std::vector<std::size_t> runs;
        for (std::size_t i = 0; i < entries.size(); ++i)
            if (i == 0 || entries[i].cell != entries[i - 1].cell) runs.push_back(i);
        std::vector<std::vector<FacePair>> found(runs.size());
        parallel_for(runs.size(), [&](std::size_t r) {
            const std::size_t end = r + 1 < runs.size() ? runs[r + 1] : entries.size();
            for (std::size_t i = runs[r]; i < end; ++i) {
                const std::int32_t f = entries[i].face;
                const std::int64_t high = box_[static_cast<std::size_t>(f)].high[0];
                for (std::size_t j = i + 1; j < end && entries[j].low <= high; ++j)
                    if (const std::int32_t g = entries[j].face; belongs_here(entries[i], entries[j]) && meet(f, g))
                        found[r].emplace_back(std::min(f, g), std::max(f, g));
            }
        });
        std::vector<FacePair> pairs;
        for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    }

private:
    struct Box {
        Point low, high;
        Point low_cell{};  ///< where `low` lies; see choose_cells()
    };
    struct Entry {
        std::int64_t cell;
        std::int32_t low;  ///< of the face's box along the first axis
        std::int32_t face;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };

    static Box bounds(const Corners& t) {
        Box box{t[0], t[0], {}};
        for (const Point& p : t)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], p[axis]);
                box.high[axis] = std::max(box.high[axis], p[axis]);
            }
        return box;
    }

    /// Cells three times as large as faces are on average: most faces lie in one to four of them.
    void choose_cells() {
        double sum = 0;
        for (const Box& box : box_)
            for (std::size_t axis = 0; axis < 3; ++axis) sum += static_cast<double>(box.high[axis] - box.low[axis]);
        const double mean = box_.empty() ? 0 : sum / (3.0 * static_cast<double>(box_.size()));
        cell_size_ = std::max(static_cast<std::int64_t>(3 * mean),
                              static_cast<std::int64_t>(steps_per_extent / max_cells_per_axis) + 1);
        for (Box& box : box_)
            for (std::size_t axis = 0; axis < 3; ++axis) box.low_cell[axis] = box.low[axis] / cell_size_;
    }

    std::int64_t cell(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return (z * (max_cells_per_axis + 1) + y) * (max_cells_per_axis + 1) + x;
    }

    std::vector<Entry> sorted_entries() const {
        std::vector<Entry> entries;
        for (std::size_t f = 0; f < corners_.size(); ++f) {
            if (!has_area(corners_[f])) continue;
            const Box& b = box_[f];
            const Point high_cell = {b.high[0] / cell_size_, b.high[1] / cell_size_, b.high[2] / cell_size_};
            for (std::int64_t z = b.low_cell[2]; z <= high_cell[2]; ++z)
                for (std::int64_t y = b.low_cell[1]; y <= high_cell[1]; ++y)
                    for (std::int64_t x = b.low_cell[0]; x <= high_cell[0]; ++x)
                        entries.push_back(
                            {cell(x, y, z), static_cast<std::int32_t>(b.low[0]), static_cast<std::int32_t>(f)});
        }
        std::sort(entries.begin(), entries.end());
        return entries;
    }

    /// Whether the boxes of two faces overlap, and this cell is the one where the overlap begins: so each pair is asked
    /// about once.
    bool belongs_here(const Entry& a, const Entry& b) const {
        const Box &p = box_[static_cast<std::size_t>(a.face)], &q = box_[static_cast<std::size_t>(b.face)];
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (std::max(p.low[axis], q.low[axis]) > std::min(p.high[axis], q.high[axis])) return false;
        const auto first = [&](std::size_t axis) { return std::max(p.low_cell[axis], q.low_cell[axis]); };
        return cell(first(0), first(1), first(2)) == a.cell;
    }

    bool meet(std::int32_t f, std::int32_t g) const {
        const Triangle &s = mesh_.triangles[static_cast<std::size_t>(f)],
                       &t = mesh_.triangles[static_cast<std::size_t>(g)];
        const Corners &a = corners_[static_cast<std::size_t>(f)], &b = corners_[static_cast<std::size_t>(g)];
        std::size_t n_shared = 0, sum_i = 0, sum_j = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                if (s[i] == t[j]) {
                    ++n_shared;
                    sum_i += i;
                    sum_j += j;
                }
        if (n_shared == 0) return disjoint_faces_meet(a, b);
        if (n_shared == 1) return corner_neighbours_meet(a, sum_i, b, sum_j);
        if (n_shared == 2) return edge_neighbours_meet(a, 3 - sum_i, b, 3 - sum_j);
        return true;  // the same triangle twice
    }

    const Mesh& mesh_;
    std::vector<Corners> corners_;
    std::vector<Box> box_;
    std::int64_t cell_size_ = 1;
};

}  // namespace

std::vector<FacePair> self_intersections(const Mesh& mesh) {
    if (mesh.triangles.empty()) return {};
    return Scene(mesh).meeting_pairs();
}

}  // namespace anyrate
