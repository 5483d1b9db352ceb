#include "core/reconstruction/hull_octree.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace anyrate {
namespace {

enum class Side { outside, inside, boundary };

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

Cell child_of(const Cell& parent, std::size_t n) {
    const auto bit = [n](int axis) { return static_cast<std::int32_t>(n >> axis & 1); };
    return {2 * parent[0] + bit(0), 2 * parent[1] + bit(1), 2 * parent[2] + bit(2)};
}

// Appends the children of parents [begin, end) that the boundary may pass.
// @param level  of the children
void divide(const Cones& cones, const WitnessRule& rule, const Cube& cube, int level, const BoundaryCells& parents,
            std::size_t begin, std::size_t end, Carved& carved) {
    const double edge = std::ldexp(cube.edge, -level);
    const auto lower_of = [&](const Cell& cell) -> Vec3 { return cube.lower + edge * Vec3(cell[0], cell[1], cell[2]); };
    const auto child = [&](std::size_t n) { return child_of(parents.cells[begin + n / 8], n % 8); };
    const std::size_t n_children = 8 * (end - begin);
    std::vector<Side> sides(n_children);
    Shown<ViewSets> shown{ViewSets(n_children, cones.size()), ViewSets(n_children, cones.size())};
    parallel_for(n_children, [&](std::size_t n) {
        std::ranges::copy(parents.shown.mixed[begin + n / 8], shown.mixed[n].begin());
        std::ranges::copy(parents.shown.object[begin + n / 8], shown.object[n].begin());
        const Vec3 centre = lower_of(child(n)).array() + 0.5 * edge;
        sides[n] = classify(cones, rule, centre, 0.5 * edge, {shown.mixed[n], shown.object[n]});
    });
    std::vector<std::size_t> kept;
    for (std::size_t n = 0; n < n_children; ++n) {
        if (sides[n] == Side::boundary) {
            kept.push_back(n);
            carved.boundary.cells.push_back(child(n));
        }
        if (sides[n] == Side::inside) {
            carved.inside.extend(lower_of(child(n)));
            carved.inside.extend(lower_of(child(n)) + Vec3::Constant(edge));
        }
    }
    carved.boundary.shown.mixed.append(shown.mixed, kept);
    carved.boundary.shown.object.append(shown.object, kept);
}

}  // namespace

Carved carve(const Cones& cones, const Cube& cube, int depth) {
    constexpr std::size_t block = 4096;  // parents at a time: sets of all children would take tens of megabytes
    const WitnessRule rule(cones);
    Carved carved{{{{0, 0, 0}}, {ViewSets(1, cones.size()), ViewSets(1, cones.size())}}, {}};
    for (std::size_t view = 0; view < cones.size(); ++view) insert(carved.boundary.shown.mixed[0], view);
    for (int level = 1; level <= depth; ++level) {
        const BoundaryCells parents = std::move(carved.boundary);
        carved.boundary = {{}, {ViewSets(0, cones.size()), ViewSets(0, cones.size())}};
        for (std::size_t begin = 0; begin < parents.cells.size(); begin += block)
            divide(cones, rule, cube, level, parents, begin, std::min(begin + block, parents.cells.size()), carved);
    }
    return carved;
}

}  // namespace anyrate
