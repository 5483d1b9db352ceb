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
#include "core/reconstruction/hull_octree.h"

namespace anyrate {
namespace {

[[noreturn]] void throw_no_common_inside(const Capture& capture) {
    throw InputError("visual hull: no point of space is inside the silhouettes of all " +
                     std::to_string(capture.views.size()) +
                     " views; expected masks of one object (0 = background) and cameras that fit them");
}

Cones make_cones(const Capture& capture) {
    std::vector<std::optional<SilhouetteCone>> made(capture.views.size());
    parallel_for(
        made.size(), [&](std::size_t i) { made[i].emplace(capture.views[i]); }, 1);
    Cones cones;
    cones.reserve(made.size());
    for (auto& cone : made) cones.push_back(std::move(*cone));
    return cones;
}

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
