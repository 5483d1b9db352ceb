#include "core/reconstruction/visual_hull.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/error.h"
#include "core/parallel.h"
#include "core/reconstruction/silhouette_cone.h"
#include "core/reconstruction/view_sets.h"

namespace anyrate {
namespace {

[[noreturn]] void throw_no_common_inside(const Capture& capture) {
    throw InputError("visual hull: no point of space is inside the silhouettes of all " +
                     std::to_string(capture.views.size()) +
                     " views; expected masks of one object (0 = background) and cameras that fit them");
}

using Cones = std::vector<SilhouetteCone>;

Cones make_cones(const Capture& capture) {
    std::vector<std::optional<SilhouetteCone>> made(capture.views.size());
    parallel_for(
        made.size(), [&](std::size_t i) { made[i].emplace(capture.views[i]); }, 1);
    Cones cones;
    cones.reserve(made.size());
    for (auto& cone : made) cones.push_back(std::move(*cone));
    return cones;
}

// The views that say something about a point, and how well they fix a place there together.
struct Witnesses {
    int n = 0;
    Mat3 across = Mat3::Zero();  // sum of the projections across the views' axes

    void add(const SilhouetteCone& cone) {
        ++n;
        if (const auto axis = cone.axis()) across += Mat3::Identity() - *axis * axis->transpose();
    }
    Witnesses& operator+=(const Witnesses& others) {
        n += others.n;
        across += others.across;
        return *this;
    }
};

// A point about which too few views say something is not part of the hull. Complete views speak of all space: two of
// them will do. Where there are none, the cones of a few neighbours still overlap far behind the object, in places that
// no other image contains: so there are to be many, or they look across each other. A place is as uncertain along its
// worst direction as the least eigenvalue of `across` is small: 1 - cos(angle) of two views. Of nefertiti's 22 images
// cut to 70 % of their sides a third of the views alone cuts off parts that six see: 0.0303 % instead of 0.0250 %.
class WitnessRule {
public:
    explicit WitnessRule(const Cones& cones) {
        const auto n_complete =
            std::count_if(cones.begin(), cones.end(), [](const auto& cone) { return cone.is_complete(); });
        is_complete_ = n_complete >= 2;
        many_ = is_complete_ ? 2 : std::max(2, static_cast<int>(cones.size()) / 3);
    }

    /// Whether so many are enough wherever they look from.
    bool are_many(int n) const { return n >= many_; }

    bool are_enough(const Witnesses& witnesses) const {
        if (are_many(witnesses.n)) return true;
        if (is_complete_ || witnesses.n < fewest) return false;
        // The least eigenvalue is above a bound if what is left without the bound is positive definite (Sylvester).
        const Mat3 left = witnesses.across - least_across * Mat3::Identity();
        return left(0, 0) > 0 && left.topLeftCorner<2, 2>().determinant() > 0 && left.determinant() > 0;
    }

private:
    static constexpr int fewest = 3;
    static constexpr double least_across = 0.5;  // as of two views 60 degrees apart
    bool is_complete_ = false;
    int many_ = 2;
};

// The hull as the negative part of a function: the largest signed distance to the cones of the views that say something
// about the point.
class HullField {
public:
    HullField(const Cones& cones, double largest) : rule_(cones), largest_(largest) {
        for (const SilhouetteCone& cone : cones) cones_.push_back(&cone);
    }

    // The same field in a cube: without the views that show nothing but object there, or nothing.
    HullField in_cube(const Vec3& centre, double half_edge) const {
        HullField local(rule_, everywhere_, largest_);
        for (const SilhouetteCone* cone : cones_) {
            const Cover cover = cone->cover(centre, half_edge);
            if (cover == Cover::object) local.everywhere_.add(*cone);
            if (cover == Cover::background || cover == Cover::mixed) local.cones_.push_back(cone);
        }
        return local;
    }

    // The same for the neighbourhood of a point.
    HullField near(const Vec3& point, double radius) const {
        HullField local(rule_, everywhere_, largest_);
        for (const SilhouetteCone* cone : cones_) {
            const auto distance = cone->distance(point);
            // A half more than the radius, as the distance is not quite Euclidean.
            if (distance && *distance < -1.5 * radius)
                local.everywhere_.add(*cone);
            else
                local.cones_.push_back(cone);
        }
        return local;
    }

    // Cut off at +-largest, so that differences stay meaningful across the frame of an image, where a cone ends.
    double operator()(const Vec3& point) const {
        double field = -largest_;
        Witnesses witnesses = everywhere_;
        for (const SilhouetteCone* cone : cones_) {
            const auto distance = cone->distance(point);
            if (!distance) continue;
            witnesses.add(*cone);
            field = std::max(field, *distance);
            if (field >= largest_) return largest_;
        }
        return rule_.are_enough(witnesses) ? field : largest_;
    }

    // By central differences of width 2 step; where two cones meet, it points between their normals.
    Vec3 gradient(const Vec3& point, double step) const {
        Vec3 difference;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 offset = step * Vec3::Unit(axis);
            difference[axis] = (*this)(point + offset) - (*this)(point - offset);
        }
        return difference / (2.0 * step);
    }

private:
    HullField(const WitnessRule& rule, const Witnesses& everywhere, double largest)
        : rule_(rule), everywhere_(everywhere), largest_(largest) {}

    std::vector<const SilhouetteCone*> cones_;
    WitnessRule rule_;
    Witnesses everywhere_;  // of the neighbourhood, without those among cones_
    double largest_;
};

// ---- the octree, level by level: only the cells of the current level are held

using Cell = std::array<std::int32_t, 3>;

// A cube of 2^depth cells an axis.
struct Cube {
    Vec3 lower;
    double edge = 0.0;
    Vec3 centre() const { return lower.array() + 0.5 * edge; }
};

enum class Side { outside, inside, boundary };

// What the views show in a cell: in one of `mixed`, to be looked at in its parts, both object and background; in one of
// `object` nothing but that; others say nothing about it.
template <class Set>
struct Shown {
    Set mixed, object;
};

Witnesses witnesses_of(const Cones& cones, ConstViewSet views) {
    Witnesses witnesses;
    all_of(views, [&](std::size_t view) {
        witnesses.add(cones[view]);
        return true;
    });
    return witnesses;
}

// A cell is outside only if some view shows its whole footprint empty, or too few views can contain any of it; so thin
// parts survive. It is inside if every view either shows nothing but object or does not see it.
// @param shown  in the cell that it is a part of; then in itself
Side classify(const Cones& cones, const WitnessRule& rule, const Vec3& centre, double half_edge, Shown<ViewSet> shown) {
    const bool may_be_inside = all_of(shown.mixed, [&](std::size_t view) {
        const Cover cover = cones[view].cover(centre, half_edge);
        if (cover != Cover::mixed) remove(shown.mixed, view);
        if (cover == Cover::object) insert(shown.object, view);
        return cover != Cover::background;
    });
    if (!may_be_inside) return Side::outside;
    if (!rule.are_many(count(shown.mixed) + count(shown.object))) {
        Witnesses witnesses = witnesses_of(cones, shown.object);
        witnesses += witnesses_of(cones, shown.mixed);
        if (!rule.are_enough(witnesses)) return Side::outside;
    }
    return count(shown.mixed) > 0 ? Side::boundary : Side::inside;
}

// Cells of one level that the hull's boundary may pass, and what the views show in each.
struct BoundaryCells {
    std::vector<Cell> cells;
    Shown<ViewSets> shown;
};

struct Carved {
    BoundaryCells boundary;      // of the last level
    Eigen::AlignedBox3d inside;  // box of the cells of all levels that lie inside
};

Cell child_of(const Cell& parent, std::size_t n) {
    const auto bit = [n](int axis) { return static_cast<std::int32_t>(n >> axis & 1); };
    return {2 * parent[0] + bit(0), 2 * parent[1] + bit(1), 2 * parent[2] + bit(2)};
}

Carved carve(const Cones& cones, const Cube& cube, int depth) {
    const WitnessRule rule(cones);
    Carved carved{{{{0, 0, 0}}, {ViewSets(1, cones.size()), ViewSets(1, cones.size())}}, {}};
    for (std::size_t view = 0; view < cones.size(); ++view) insert(carved.boundary.shown.mixed[0], view);
    for (int level = 1; level <= depth; ++level) {
        const double edge = std::ldexp(cube.edge, -level);
        const auto lower_of = [&](const Cell& cell) -> Vec3 {
            return cube.lower + edge * Vec3(cell[0], cell[1], cell[2]);
        };
        const BoundaryCells parents = std::move(carved.boundary);
        const std::size_t n_children = 8 * parents.cells.size();
        std::vector<Side> sides(n_children);
        Shown<ViewSets> shown{ViewSets(n_children, cones.size()), ViewSets(n_children, cones.size())};
        parallel_for(n_children, [&](std::size_t n) {
            std::ranges::copy(parents.shown.mixed[n / 8], shown.mixed[n].begin());
            std::ranges::copy(parents.shown.object[n / 8], shown.object[n].begin());
            const Vec3 lower = lower_of(child_of(parents.cells[n / 8], n % 8));
            sides[n] = classify(cones, rule, lower.array() + 0.5 * edge, 0.5 * edge, {shown.mixed[n], shown.object[n]});
        });
        std::vector<std::size_t> kept;
        std::vector<Cell> cells;
        for (std::size_t n = 0; n < n_children; ++n) {
            const Cell child = child_of(parents.cells[n / 8], n % 8);
            if (sides[n] == Side::boundary) {
                kept.push_back(n);
                cells.push_back(child);
            }
            if (sides[n] == Side::inside) {
                carved.inside.extend(lower_of(child));
                carved.inside.extend(lower_of(child) + Vec3::Constant(edge));
            }
        }
        shown.mixed.keep(kept);
        shown.object.keep(kept);
        carved.boundary = {std::move(cells), std::move(shown)};
    }
    return carved;
}

// ---- where the object is

// The point nearest to the rays through the middles of all masks, and a cube around it up to the farthest camera.
std::optional<Cube> first_guess(const Cones& cones) {
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (const SilhouetteCone& cone : cones) {
        const auto axis = cone.axis();
        if (!axis) return std::nullopt;
        const Mat3 across = Mat3::Identity() - *axis * axis->transpose();
        A += across;
        b += across * (cone.camera_centre() - cones.front().camera_centre());
    }
    const Vec3 nearest = cones.front().camera_centre() + A.ldlt().solve(b);
    double reach = 0.0;
    for (const SilhouetteCone& cone : cones) reach = std::max(reach, (cone.camera_centre() - nearest).norm());
    if (!nearest.allFinite() || !(reach > 0.0)) return std::nullopt;
    return Cube{nearest - Vec3::Constant(reach), 2.0 * reach};
}

// Carves coarsely and closes in on what is left, until that no longer helps.
std::optional<Eigen::AlignedBox3d> find_object(const Cones& cones) {
    constexpr int depth = 5, most_rounds = 12;
    auto cube = first_guess(cones);
    if (!cube) return std::nullopt;
    Eigen::AlignedBox3d box;
    for (int round = 0; round < most_rounds; ++round) {
        const Carved carved = carve(cones, *cube, depth);
        const double edge = std::ldexp(cube->edge, -depth);
        box = carved.inside;
        for (const Cell& cell : carved.boundary.cells) {
            const Vec3 lower = cube->lower + edge * Vec3(cell[0], cell[1], cell[2]);
            box.extend(lower);
            box.extend(lower + Vec3::Constant(edge));
        }
        if (box.isEmpty()) return std::nullopt;
        const double size = box.sizes().maxCoeff();
        if (size > 0.8 * cube->edge) break;
        cube = Cube{box.center() - Vec3::Constant(0.5 * size), size};
    }
    return box;
}

// The cube to carve finely: its cells have the edge asked for in pixels of the views, where `depth` allows.
Cube fine_cube(const Cones& cones, const Eigen::AlignedBox3d& box, const HullOptions& options, int& depth) {
    const Vec3 centre = box.center();
    std::vector<double> pixel_sizes;
    for (const SilhouetteCone& cone : cones)
        if (const double size = cone.pixel_size(centre); size > 0.0) pixel_sizes.push_back(size);
    const double extent = box.sizes().maxCoeff();
    double cell = std::ldexp(extent, -options.max_depth);
    if (!pixel_sizes.empty()) {
        const auto median = pixel_sizes.begin() + static_cast<std::ptrdiff_t>(pixel_sizes.size() / 2);
        std::nth_element(pixel_sizes.begin(), median, pixel_sizes.end());
        cell = std::max(cell, options.pixels_per_cell * *median);
    }
    depth = std::clamp(static_cast<int>(std::ceil(std::log2(extent / cell))), 1, options.max_depth);
    const double edge = std::max(extent, std::ldexp(cell, depth));
    return Cube{centre - Vec3::Constant(0.5 * edge), edge};
}

// ---- from boundary cells to points

enum Mark : std::uint8_t { unknown, needed, taken, inside, outside };

// What is known of the corners of the boundary cells: on a dense grid over just these cells, a byte a node.
struct CornerGrid {
    Cell first;         // whose lower corner is node (0, 0, 0)
    Vec3 lower;         // of that node, world units
    double edge = 0.0;  // of a cell
    std::array<std::size_t, 3> size = {};
    std::vector<Mark> marks;

    std::size_t plane() const { return size[0] * size[1]; }
    std::size_t node(std::size_t i, std::size_t j, std::size_t k) const { return k * plane() + j * size[0] + i; }
    Vec3 position(std::size_t i, std::size_t j, std::size_t k) const {
        return lower + edge * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    }

    // The node at a cell's corner, whose bits tell the upper from the lower along each axis.
    std::array<std::size_t, 3> corner_of(const Cell& cell, int corner) const {
        std::array<std::size_t, 3> at;
        for (std::size_t axis = 0; axis < 3; ++axis)
            at[axis] = static_cast<std::size_t>(cell[axis] - first[axis] + (corner >> axis & 1));
        return at;
    }
    Mark& mark_of(const Cell& cell, int corner) {
        const auto [i, j, k] = corner_of(cell, corner);
        return marks[node(i, j, k)];
    }
    Vec3 position_of(const Cell& cell, int corner) const {
        const auto [i, j, k] = corner_of(cell, corner);
        return position(i, j, k);
    }
};

CornerGrid corners_of(const std::vector<Cell>& cells, const Cube& cube, int depth) {
    Eigen::AlignedBox<int, 3> box;
    for (const Cell& cell : cells) box.extend(Eigen::Vector3i(cell[0], cell[1], cell[2]));
    CornerGrid grid;
    grid.edge = std::ldexp(cube.edge, -depth);
    grid.first = {box.min()[0], box.min()[1], box.min()[2]};
    grid.lower = cube.lower + grid.edge * box.min().cast<double>();
    for (int axis = 0; axis < 3; ++axis)
        grid.size[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(box.sizes()[axis] + 2);
    grid.marks.assign(grid.plane() * grid.size[2], Mark::unknown);
    for (const Cell& cell : cells)
        for (int corner = 0; corner < 8; ++corner) grid.mark_of(cell, corner) = Mark::needed;
    return grid;
}

// A view that shows nothing but object in a cell does so at its corners.
bool is_inside(const Cones& cones, const WitnessRule& rule, const Vec3& point, Shown<ConstViewSet> shown) {
    int n_seeing = count(shown.object);
    const bool may_be = all_of(shown.mixed, [&](std::size_t view) {
        const auto distance = cones[view].distance(point);
        n_seeing += distance ? 1 : 0;
        return !distance || *distance < 0.0;
    });
    if (!may_be || rule.are_many(n_seeing)) return may_be;
    Witnesses witnesses = witnesses_of(cones, shown.object);
    all_of(shown.mixed, [&](std::size_t view) {
        if (cones[view].distance(point)) witnesses.add(cones[view]);
        return true;
    });
    return rule.are_enough(witnesses);
}

// Whichever cell comes first tells of a corner; all that share it would say the same.
void evaluate_corners(const Cones& cones, const BoundaryCells& boundary, CornerGrid& grid) {
    const WitnessRule rule(cones);
    parallel_for(boundary.cells.size(), [&](std::size_t n) {
        for (int corner = 0; corner < 8; ++corner) {
            const std::atomic_ref<Mark> mark(grid.mark_of(boundary.cells[n], corner));
            Mark expected = Mark::needed;
            if (!mark.compare_exchange_strong(expected, Mark::taken, std::memory_order_relaxed)) continue;
            const Vec3 point = grid.position_of(boundary.cells[n], corner);
            const bool inside = is_inside(cones, rule, point, {boundary.shown.mixed[n], boundary.shown.object[n]});
            mark.store(inside ? Mark::inside : Mark::outside, std::memory_order_relaxed);
        }
    });
}

// The surface point between an inner and an outer point, by the Illinois variant of regula falsi (Dowell and Jarratt
// 1971), which keeps the bracket: the field may jump at the frame of an incomplete view.
Vec3 crossing(const HullField& field, Vec3 in, Vec3 out) {
    constexpr int n_steps = 4;
    double field_in = field(in), field_out = field(out);
    if (!(field_in < 0.0 && field_out >= 0.0)) return 0.5 * (in + out);
    const auto root = [&]() -> Vec3 { return in + (out - in) * (field_in / (field_in - field_out)); };
    for (int step = 0; step < n_steps; ++step) {
        const Vec3 middle = root();
        const double value = field(middle);
        if (value < 0.0) {
            in = middle;
            field_in = value;
            field_out *= 0.5;
        } else {
            out = middle;
            field_out = value;
            field_in *= 0.5;
        }
    }
    return root();
}

// One point for each edge of a boundary cell that the surface crosses. Such edges cut a surface element of normal n at
// a rate of (|n_x| + |n_y| + |n_z|) / edge^2, whence the area of each point.
std::vector<OrientedPoint> boundary_points(const HullField& field, const CornerGrid& grid) {
    std::vector<std::vector<OrientedPoint>> of_row(grid.size[1] * grid.size[2]);
    const double step = 0.5 * grid.edge;
    const auto try_edge = [&](const auto& field_around, const Vec3& from, Mark mark_from, int axis, Mark mark_to,
                              std::vector<OrientedPoint>& points) {
        if (mark_from < Mark::inside || mark_to < Mark::inside || mark_from == mark_to) return;
        const Vec3 to = from + grid.edge * Vec3::Unit(axis);
        const HullField local = field_around().near(0.5 * (from + to), step + step);
        OrientedPoint point;
        point.position = mark_from == Mark::inside ? crossing(local, from, to) : crossing(local, to, from);
        const Vec3 gradient = local.gradient(point.position, step);
        if (!(gradient.norm() > 0.0)) return;
        point.normal = gradient.normalized();
        point.area = grid.edge * grid.edge / point.normal.lpNorm<1>();
        points.push_back(point);
    };
    const auto try_edges_of = [&](const auto& field_around, std::size_t i, std::size_t j, std::size_t k) {
        const std::size_t node = grid.node(i, j, k);
        const Mark mark = grid.marks[node];
        if (mark < Mark::inside) return;
        const Vec3 from = grid.position(i, j, k);
        std::vector<OrientedPoint>& points = of_row[k * grid.size[1] + j];
        if (i + 1 < grid.size[0]) try_edge(field_around, from, mark, 0, grid.marks[node + 1], points);
        if (j + 1 < grid.size[1]) try_edge(field_around, from, mark, 1, grid.marks[node + grid.size[0]], points);
        if (k + 1 < grid.size[2]) try_edge(field_around, from, mark, 2, grid.marks[node + grid.plane()], points);
    };
    // Blocks of nodes share what most views say of them: that all is object.
    constexpr std::size_t side = 4;
    const std::size_t n_across = (grid.size[1] + side - 1) / side;
    parallel_for(
        n_across * ((grid.size[2] + side - 1) / side),
        [&](std::size_t rows) {
            const std::size_t j0 = rows % n_across * side, k0 = rows / n_across * side;
            for (std::size_t i0 = 0; i0 < grid.size[0]; i0 += side) {
                std::optional<HullField> in_block;
                const auto field_around = [&]() -> const HullField& {
                    // Its nodes' edges, and as much around them as the gradient looks at.
                    const double half_edge = 0.5 * side * grid.edge + step;
                    if (!in_block)
                        in_block = field.in_cube(grid.position(i0, j0, k0).array() + 0.5 * side * grid.edge, half_edge);
                    return *in_block;
                };
                for (std::size_t k = k0; k < std::min(k0 + side, grid.size[2]); ++k)
                    for (std::size_t j = j0; j < std::min(j0 + side, grid.size[1]); ++j)
                        for (std::size_t i = i0; i < std::min(i0 + side, grid.size[0]); ++i)
                            try_edges_of(field_around, i, j, k);
            }
        },
        1);
    std::vector<OrientedPoint> points;
    for (const auto& row : of_row) points.insert(points.end(), row.begin(), row.end());
    return points;
}

}  // namespace

VisualHull visual_hull(const Capture& capture, const HullOptions& options) {
    const Cones cones = make_cones(capture);
    const auto box = find_object(cones);
    if (!box) throw_no_common_inside(capture);
    int depth = 0;
    const Cube cube = fine_cube(cones, *box, options, depth);
    const Carved carved = carve(cones, cube, depth);
    CornerGrid grid = corners_of(carved.boundary.cells, cube, depth);
    evaluate_corners(cones, carved.boundary, grid);
    const HullField field(cones, 2.0 * grid.edge);

    VisualHull hull;
    hull.cell = grid.edge;
    hull.points = boundary_points(field, grid);
    if (hull.points.empty()) throw_no_common_inside(capture);
    Eigen::AlignedBox3d tight;
    for (const OrientedPoint& point : hull.points) tight.extend(point.position);
    hull.lower = tight.min();
    hull.upper = tight.max();
    return hull;
}

}  // namespace anyrate
